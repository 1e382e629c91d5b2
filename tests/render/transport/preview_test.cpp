// Previews of paths of light: what their bias is, by closed forms.
#include "tests/support/path_light.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

constexpr double kTau = 0.08, kAlbedo = 0.7, kIntensity = 2;

/// Light of paths that begin in the middle of an even medium, under a white sky and a light.
struct InAnEvenMedium {
    Mean light(PathPreview preview, int bounces, int paths) const {
        Transport transport = transportOf(bounces);
        transport.preview = preview;
        const PathScene scene = volume.scene(transport, {lightFrom(kTowards, kIntensity)}, Environment{});
        double sum = 0, squares = 0;
        PathWork work;
        for (int number = 0; number < paths; ++number) {
            TracedPath path(
                scene, {static_cast<float>(number % 4096) + 0.5f, static_cast<float>(number / 4096) + 0.5f});
            PathTracer tracer(scene, volume, work);
            path.p = kFrom;
            path.travel = {0, 0, 1};
            path.tissue.albedo = glm::vec3(static_cast<float>(kAlbedo));
            const auto light = static_cast<double>(tracer.lightFrom(path).r);
            sum += light, squares += light * light;
        }
        const double mean = sum / paths;
        return {mean, std::sqrt((squares / paths - mean * mean) / paths)};
    }
    double depth(const glm::vec3& direction) const { // to the volume's border
        return kTau * static_cast<double>(mmToLeave(kFrom, direction, glm::vec3(volume.extent())));
    }
    static inline const glm::dvec3 kTowards = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));
    static inline const glm::vec3 kFrom{9, 10, 8};
    PathVolume volume{
        {20, 20, 20}, [](const glm::ivec3&) { return static_cast<float>(kTau); }, kTau, glm::dvec3(kAlbedo)};
};

/// Light of the second place is attenuated as the way to it is.
TEST(Previews, SquaredCountsTheAttenuationTwice) {
    const InAnEvenMedium medium;
    constexpr int kFine = 300;
    double expected = kAlbedo * kIntensity / 4 * std::exp(-medium.depth(glm::vec3(medium.kTowards)));
    for (int n = 0; n < kFine * kFine; ++n) {
        const float z = 1 - 2 * (static_cast<float>(n / kFine) + 0.5f) / kFine;
        const double depth =
            medium.depth(directionAround({0, 0, 1}, z, (static_cast<float>(n % kFine) + 0.5f) / kFine));
        const double second = kAlbedo * kAlbedo * (1 + kIntensity / 4) * -std::expm1(-2 * depth) / 2;
        expected += (kAlbedo * std::exp(-depth) + second) / (kFine * kFine);
    }
    const Mean light = medium.light(PathPreview::squared, 8, 200000);
    EXPECT_NEAR(light.mean, expected, 4 * light.error + 1e-4);
    EXPECT_LT(light.error, 0.005 * expected);
    const Mean truth = medium.light(PathPreview::none, 256, 100000);
    EXPECT_GT(std::abs(truth.mean - light.mean), 20 * light.error) << "a bias that nobody can see";
}

/// In a medium the way after the third scattering brings what it would bring if the path ended there.
TEST(Previews, FewIsThreeScatterings) {
    const InAnEvenMedium medium;
    const Mean few = medium.light(PathPreview::few, 8, 100000),
               three = medium.light(PathPreview::none, 3, 100000),
               all = medium.light(PathPreview::none, 256, 100000);
    EXPECT_NEAR(few.mean, three.mean, 4 * std::hypot(few.error, three.error));
    EXPECT_LT(few.error, three.error);
    EXPECT_GT(all.mean - few.mean, 10 * few.error);
    const Mean two = medium.light(PathPreview::few, 2, 20000); // of that many at most
    EXPECT_LT(two.mean, few.mean - 4 * two.error);
}

} // namespace
} // namespace tessera

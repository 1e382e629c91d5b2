// tests/render/light_error_test.cpp: how far the light of voxels is from that of the reference, and occlusion
// by a few rays from that by many; and that no light makes any engine draw nonsense.
#include "core/image_metrics.h"
#include "render/light/directions.h"
#include "render/light/stored_light.h"
#include "tests/support/native_fixture.h"
#include "tests/support/reference_light.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

struct PictureCase {
    const char *store, *preset;
    bool occlusion, shadow;
    double rms[2], luvP99[2]; // at finest level 0 and 1
};

/// Light of voxels, through the mirror, against rays of light from every place that is seen.
void expectNear(const PictureCase& c) {
    Lighting lighting;
    if (c.occlusion)
        lighting.occlusion = Occlusion{};
    if (c.shadow) {
        lighting.lights = {keyLight()};
        lighting.lights[0].frame = LightFrame::camera;
    }
    Image truth;
    for (int level = 0; level < 2; ++level) {
        Scene scene = sceneOn(infoOf(c.store), c.preset, 0, {20, 20});
        scene.lighting = lighting;
        scene.lighting.finestLevel = level;
        scene.quality.integrator = Integrator::preintegrated;
        Prepared prepared(c.store, scene);
        const ScenePlan& p = prepared.p;
        if (level == 0)
            truth = referencePicture(referenceInput(prepared, scene), prepared);
        MirrorInput input = mirrorInput(p, true);
        std::optional<SceneLight> light;
        std::optional<StoredLight> stored;
        if (c.occlusion || c.shadow) {
            light.emplace(p, 0);
            stored.emplace(*light, p, prepared.budgets.ram);
            input.light = &*stored;
        }
        Image image(p.view.imageSize);
        Work work;
        image.pixels =
            mirrorRays<float>(input, image.pixels.size(), frameRays(cast<float>(p.view.frame)), 0, work);
        const ImageDifference d = compare(image, truth);
        tell("%s %s%s%s level %d: rms %.3g bias %.3g luv mean %.3g p99 %.3g pixels %zu\n", c.store, c.preset,
             c.occlusion ? " occlusion" : "", c.shadow ? " shadow" : "", level, d.rms, d.bias, d.luvMean,
             d.luvP99, d.maskedPixels);
        const std::string what = std::string(c.store) + (c.occlusion ? " occlusion" : "") +
                                 (c.shadow ? " shadow" : "") + " at level " + std::to_string(level);
        EXPECT_LT(d.rms, c.rms[level]) << what;
        EXPECT_LT(d.luvP99, c.luvP99[level]) << what;
        EXPECT_GT(d.maskedPixels, 30u) << what;
    }
}

// Twice what was measured. Of the rms and the distances of no light at all (0.010 and 3.6; 0.0094 and 8.4)
// the march's step makes part of each; the rest is light that is known at samples only: surfaces lie between
// them, where light changes most, and at level 1 between samples twice as far apart. Where directional
// lights' shadows begin at the sample itself, the rms is 0.07.
TEST(LightError, PicturesOfTheTorso) {
    expectNear({"torso", "bone", false, false, {0.021, 0.021}, {7.3, 7.3}});
    expectNear({"torso", "bone", true, false, {0.037, 0.06}, {6.5, 9}});
    expectNear({"torso", "bone", false, true, {0.018, 0.025}, {7.8, 12.2}});
    expectNear({"torso", "bone", true, true, {0.032, 0.061}, {12.7, 26}});
}
TEST(LightError, PicturesOfTheAbdomen) {
    if (!std::filesystem::exists(storePath("abdomen")))
        GTEST_SKIP() << "the scan is absent";
    expectNear({"abdomen", "bone", false, false, {0.019, 0.019}, {16.8, 16.8}});
    expectNear({"abdomen", "bone", true, false, {0.031, 0.046}, {16.9, 16.9}});
    expectNear({"abdomen", "bone", false, true, {0.024, 0.041}, {14.8, 21}});
    expectNear({"abdomen", "bone", true, true, {0.029, 0.058}, {16.7, 27.4}});
}

/// As evenly spread as directions can be: a spiral with one of them for every equal slice of the sphere.
std::vector<glm::dvec3> spiral(int count) {
    std::vector<glm::dvec3> all;
    for (int n = 0; n < count; ++n) {
        const double z = 1 - (2 * n + 1.0) / count, r = std::sqrt(1 - z * z), angle = n * 2.399963229728653;
        all.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
    return all;
}

/// Parts of the sphere that are nearest to each direction; together 1.
std::vector<double> partsOfSphere(const std::vector<glm::dvec3>& directions) {
    std::vector<double> parts(directions.size());
    const std::vector<glm::dvec3> places = spiral(40000);
    for (const glm::dvec3& place : places) {
        std::size_t nearest = 0;
        for (std::size_t n = 1; n < directions.size(); ++n)
            if (glm::dot(directions[n], place) > glm::dot(directions[nearest], place))
                nearest = n;
        parts[nearest] += 1.0 / static_cast<double>(places.size());
    }
    return parts;
}

/// Errors of K rays against 4096, at samples that show something. Weighted by the parts of the sphere that
/// they stand for they fall at least as their number's root. All alike, as occlusion takes them, they do so
/// down to a floor: faces cut into four at the middles of their edges are not of one size, so that directions
/// crowd around a solid's corners, around a tetrahedron's most.
void expectFallingWithRays(const char* store, const char* preset) {
    Scene scene = sceneOn(infoOf(store), preset, 0, {8, 8});
    scene.lighting.occlusion = Occlusion{};
    Prepared prepared(store, scene);
    std::mt19937 random(3);
    std::vector<glm::dvec3> places; // patient space
    RaysOfLight rays(prepared, scene);
    const glm::ivec3 extent = prepared.p.info().extentVoxels;
    while (places.size() < 120) {
        const glm::ivec3 voxel(std::uniform_int_distribution(0, extent.x - 1)(random),
                               std::uniform_int_distribution(0, extent.y - 1)(random),
                               std::uniform_int_distribution(0, extent.z - 1)(random));
        if (rays.function.extinction(rays.samples.at(voxel)) > 0)
            places.push_back(rays.patient(glm::dvec3(voxel) + 0.5));
    }
    const auto mean = [&](const glm::dvec3& place, const std::vector<glm::dvec3>& directions,
                          const std::vector<double>& parts) {
        double sum = 0;
        for (std::size_t n = 0; n < directions.size(); ++n)
            sum += parts[n] * rays.light.openness(place, directions[n]);
        return sum;
    };
    std::vector<double> truth;
    for (const glm::dvec3& place : places)
        truth.push_back(mean(place, spiral(4096), std::vector<double>(4096, 1.0 / 4096)));
    double first = 0;
    constexpr double kFloor = 0.009;
    for (const int count : {4, 8, 16, 20, 32, 64, 80, 128, 256, 320, 512}) {
        const std::vector<glm::dvec3> directions = sphereDirections(count);
        const std::vector<double> parts = partsOfSphere(directions), alike(directions.size(), 1.0 / count);
        double sum = 0, weighted = 0;
        for (std::size_t n = 0; n < places.size(); ++n) {
            sum += std::pow(mean(places[n], directions, alike) - truth[n], 2);
            weighted += std::pow(mean(places[n], directions, parts) - truth[n], 2);
        }
        const double rms = std::sqrt(sum / static_cast<double>(places.size())),
                     rmsWeighted = std::sqrt(weighted / static_cast<double>(places.size()));
        first = count == 4 ? rms : first;
        const double root = first * std::sqrt(4.0 / count);
        tell("| %s, %s | %d | %.5f | %.5f | %.5f |\n", store, preset, count, rms, rmsWeighted, root);
        EXPECT_LT(rms, std::max(1.25 * root, kFloor)) << store << ", " << count;
        EXPECT_LT(rmsWeighted, 1.25 * root) << store << ", " << count;
    }
}

TEST(LightError, OcclusionFallsWithRays) {
    expectFallingWithRays("torso", "soft-tissue");
    if (std::filesystem::exists(storePath("abdomen")))
        expectFallingWithRays("abdomen", "bone");
}

/// Lights that nobody would set, by native engine, march and reference: finite, no brighter than the light
/// that there is, and drawn to the end.
void expectSane(const std::string& what, const std::string& preset, const TransferFunction* function,
                const Lighting& lighting) {
    SCOPED_TRACE(what + ", " + preset);
    Scene scene = sceneOn(infoOf("sphere"), preset, 0, {10, 10});
    if (function)
        scene.volumes[0].transferFunction = *function;
    scene.lighting = lighting;
    Prepared prepared("sphere", scene);
    prepared.p.view.shadowQuality.mapSize = 32;
    const double most = 1.5 * std::max(1.0, mostLight(lighting.lights)) *
                        (scene.shading.ambient * 1.1 + scene.shading.diffuse + scene.shading.specular);
    const auto check = [&](const Image& image, const char* engine) {
        for (const glm::vec4& p : image.pixels)
            for (int c = 0; c < 4; ++c) {
                ASSERT_TRUE(std::isfinite(p[c])) << engine;
                ASSERT_GE(p[c], 0) << engine;
                ASSERT_LE(static_cast<double>(p[c]), c == 3 ? 1 + 1e-5 : most) << engine;
            }
    };
    check(referencePicture(referenceInput(prepared, scene), prepared), "reference");
    check(nativePicture(prepared).image, "native");
    check(marchOn(prepared, kFeatureSkipping | kFeatureShading).image, "march");
}

TEST(LightExtremes, AreFiniteAndBounded) {
    const GlContext context({"software"});
    const VolumeInfo info = infoOf("sphere");
    const auto pointAt = [&](const glm::dvec3& voxel, double softness) {
        Lighting lighting;
        Light light = keyLight(softness);
        light.kind = LightKind::point;
        light.position = glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1));
        lighting.lights = {light};
        lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6};
        return lighting;
    };
    const TransferFunction nothing = TransferFunction::fromExtinction({}, {}),
                           wall = TransferFunction::fromOpacity({{0, 1}}, {}, 1e-3);
    Lighting without = pointAt(glm::dvec3(0), 0), far = without;
    without.lights[0].kind = LightKind::directional;
    without.lights[0].direction = glm::dvec3(0);
    far.occlusion = Occlusion{.rays = 8, .radiusMm = 1e5};
    for (const TransferFunction* function :
         {static_cast<const TransferFunction*>(nullptr), &nothing, &wall}) {
        expectSane("a light inside", "bone", function, pointAt(glm::dvec3(info.extentVoxels) * 0.45, 0));
        expectSane("a large one inside", "bone", function, pointAt(glm::dvec3(info.extentVoxels) * 0.45, 90));
        expectSane("on a corner of bricks", "bone", function, pointAt({32, 32, 32}, 0));
        expectSane("behind bone", "bone", function, pointAt({-9, 200, 25}, 0));
        expectSane("without a direction", "bone", function, without);
        expectSane("a radius beyond the volume", "bone", function, far);
    }
}

} // namespace
} // namespace tessera::test

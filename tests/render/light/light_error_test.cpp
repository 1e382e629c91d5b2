// tests/render/light/light_error_test.cpp: the error of the light of voxels against the reference, and of
// occlusion by a few rays against many. Under no light does an engine draw invalid values.
#include "core/image/image_metrics.h"
#include "core/scene/preset.h"
#include "render/light/directions.h"
#include "render/light/scene_light.h"
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
    double emission = 0;      // of everything that is shown
};

/// Light of voxels, through the mirror, against rays of light from every place that is seen.
void expectNear(const PictureCase& c) {
    Lighting lighting;
    if (c.occlusion)
        lighting.occlusion = Occlusion{.emission = c.emission};
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
        if (c.emission > 0) {
            TransferFunction function = presetFunction(c.preset, {-1000, 2000, true, 1, {}});
            function.setMaterials({{-4000, 4000, 0.3, 0.6, 0.2, 20, {0.05, 0.02, 0.01}}});
            scene.volumes[0].transferFunction = function;
        }
        Prepared prepared(c.store, scene);
        const FramePlan& p = prepared.p;
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
        tell("%s %s%s%s%s level %d: rms %.3g bias %.3g luv mean %.3g p99 %.3g pixels %zu\n", c.store,
             c.preset, c.occlusion ? " occlusion" : "", c.shadow ? " shadow" : "",
             c.emission > 0 ? " emission" : "", level, d.rms, d.bias, d.luvMean, d.luvP99, d.maskedPixels);
        const std::string what = std::string(c.store) + (c.occlusion ? " occlusion" : "") +
                                 (c.shadow ? " shadow" : "") + " at level " + std::to_string(level);
        EXPECT_LT(d.rms, c.rms[level]) << what;
        EXPECT_LT(d.luvP99, c.luvP99[level]) << what;
        EXPECT_GT(d.maskedPixels, 30u) << what;
    }
}

// Twice the measured errors. The ray caster's step causes part of the rms and of the distances without light
// (0.010 and 3.6; 0.0094 and 8.4). The rest is light that is known only at samples. Surfaces lie between
// them, where light changes most, and at level 1 between samples twice as far apart. If directional lights'
// shadows begin at the sample itself, the rms is 0.07.
TEST(LightError, PicturesOfTheTorso) {
    expectNear({"torso", "bone-1", false, false, {0.021, 0.021}, {7.3, 7.3}});
    expectNear({"torso", "bone-1", true, false, {0.022, 0.032}, {7.7, 6.6}});
    expectNear({"torso", "bone-1", false, true, {0.018, 0.025}, {7.8, 12.2}});
    expectNear({"torso", "bone-1", true, true, {0.02, 0.034}, {8.9, 20.5}});
    expectNear({"torso", "bone-1", true, false, {0.021, 0.05}, {6.4, 8.4}, 20});
}
TEST(LightError, PicturesOfTheAbdomen) {
    if (!std::filesystem::exists(storePath("abdomen")))
        GTEST_SKIP() << "the scan is absent";
    expectNear({"abdomen", "bone-1", false, false, {0.019, 0.019}, {16.8, 16.8}});
    expectNear({"abdomen", "bone-1", true, false, {0.02, 0.026}, {16.9, 16.9}});
    expectNear({"abdomen", "bone-1", false, true, {0.024, 0.041}, {14.8, 21}});
    expectNear({"abdomen", "bone-1", true, true, {0.023, 0.045}, {15.9, 23.9}});
}

/// As evenly spread as directions can be: a spiral with one of them for every equal slice of the sphere.
std::vector<SphereDirection> spiral(int count) {
    std::vector<SphereDirection> all;
    for (int n = 0; n < count; ++n) {
        const double z = 1 - (2 * n + 1.0) / count, r = std::sqrt(1 - z * z), angle = n * 2.399963229728653;
        all.push_back({{r * std::cos(angle), r * std::sin(angle), z}, 1.0 / count});
    }
    return all;
}

/// Errors of K rays against 4096, at samples that show something: they fall at least as their number's root.
/// With equal weights they would do so only down to a floor. Faces cut into four at the middles of their
/// edges differ in size, so that directions crowd around a solid's corners. They do so most around a
/// tetrahedron's (256 of them: 0.005 and 0.008, where the root gives 0.003 and 0.005).
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
    const auto mean = [&](const glm::dvec3& place, const std::vector<SphereDirection>& directions) {
        double sum = 0;
        for (const auto& [towards, part] : directions)
            sum += part * rays.light.openness(place, towards);
        return sum;
    };
    std::vector<double> truth;
    for (const glm::dvec3& place : places)
        truth.push_back(mean(place, spiral(4096)));
    double first = 0;
    for (const int count : {4, 8, 16, 20, 32, 64, 80, 128, 256, 320, 512}) {
        const std::vector<SphereDirection> directions = sphereDirections(count);
        double sum = 0;
        for (std::size_t n = 0; n < places.size(); ++n)
            sum += std::pow(mean(places[n], directions) - truth[n], 2);
        const double rms = std::sqrt(sum / static_cast<double>(places.size()));
        first = count == 4 ? rms : first;
        const double root = first * std::sqrt(4.0 / count);
        tell("| %s, %s | %d | %.5f | %.5f |\n", store, preset, count, rms, root);
        EXPECT_LE(rms, root) << store << ", " << count;
    }
}

TEST(LightError, OcclusionFallsWithRays) {
    expectFallingWithRays("torso", "soft-tissue");
    if (std::filesystem::exists(storePath("abdomen")))
        expectFallingWithRays("abdomen", "bone-1");
}

/// Sources of the error of kept occlusion, at places that rays of the eye see. Of samples. The layers that
/// rays read are too far apart to resolve how fast extinction falls beside a surface. So samples there are a
/// little too dark (bone -0.03 and -0.024, soft tissue -0.008 and -0.010). Without the half step that begins
/// in the sample itself they would be too bright, by 0.13, 0.085, 0.059 and 0.023. Between samples: light
/// falls ever slower on the way into a surface, so that a line between two samples lies above it (0.011,
/// 0.016, 0.007, 0.003). Together within 0.018.
void expectParts(const char* store, const char* preset) {
    Scene scene = sceneOn(infoOf(store), preset, 0, {24, 24});
    scene.lighting.occlusion = Occlusion{};
    Prepared prepared(store, scene);
    Planner& p = prepared.p;
    SceneLight light(p, 0);
    const StoredLight stored(light, p, prepared.budgets.ram);
    RaysOfLight rays(prepared, scene);
    const glm::dvec3 extent(p.info().extentVoxels);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> part(0, 1);
    double samples[2] = {}, between[2] = {}, kept[2] = {}, shares = 0, n = 0;
    const auto add = [](double(&to)[2], double d) {
        to[0] += d;
        to[1] += d * d;
    };
    const auto lattice = [&](const glm::dvec3& place, const auto& at) {
        const glm::dvec3 q = glm::clamp(place, glm::dvec3(0.5), extent - 0.5) - 0.5;
        const glm::dvec3 low = glm::min(glm::floor(q), extent - 2.0), f = q - low;
        double sum = 0;
        for (int c = 0; c < 8; ++c) {
            const glm::dvec3 corner(c & 1, (c >> 1) & 1, c >> 2);
            const glm::dvec3 w = glm::mix(1.0 - f, f, corner);
            if (w.x * w.y * w.z > 1e-9)
                sum += w.x * w.y * w.z * at(low + corner + 0.5);
        }
        return sum;
    };
    for (const ReferenceRay& ray : referenceRays(p.view.camera, p.info(), p.view.imageSize)) {
        double t0 = 0, t1 = 0;
        if (!clipToBox(RayLine<double>{ray.base, ray.direction, 0, 1}, extent, t0, t1))
            continue;
        const double until = part(random);
        double left = 1, step = 0.25 / glm::length(ray.direction);
        for (double t = t0 + step * part(random); t < t1; t += step) {
            const glm::dvec3 place = ray.base + t * ray.direction;
            const double value =
                lattice(place, [&](const glm::dvec3& c) { return rays.samples.at(glm::ivec3(c)); });
            left *= std::exp(-rays.function.extinction(value) * step);
            if (1 - left < until)
                continue;
            const double truth = rays.light.at(place)[0];
            const double exact = lattice(place, [&](const glm::dvec3& c) { return rays.light.at(c)[0]; });
            const double mine = stored.at<double>(place, p.layer().optics.lighting).fromAllSides[0];
            add(between, exact - truth);
            add(samples, mine - exact);
            add(kept, mine - truth);
            shares += truth;
            ++n;
            break;
        }
    }
    tell("%s %s: %g places, A %.4f; between samples bias %.4f rms %.4f; samples %.4f %.4f; both %.4f %.4f\n",
         store, preset, n, shares / n, between[0] / n, std::sqrt(between[1] / n), samples[0] / n,
         std::sqrt(samples[1] / n), kept[0] / n, std::sqrt(kept[1] / n));
    EXPECT_GT(n, 100);
    EXPECT_LT(std::abs(samples[0] / n), 0.045) << store << ", " << preset;
    EXPECT_LT(std::abs(between[0] / n), 0.025) << store << ", " << preset;
    EXPECT_LT(std::abs(kept[0] / n), 0.03) << store << ", " << preset;
    EXPECT_LT(std::sqrt(kept[1] / n), 0.1) << store << ", " << preset;
}

TEST(LightError, OfOcclusionByItsParts) {
    for (const char* preset : {"bone-1", "soft-tissue"}) {
        expectParts("torso", preset);
        if (std::filesystem::exists(storePath("abdomen")))
            expectParts("abdomen", preset);
    }
}

/// Extreme lights, by native engine, GPU ray caster and reference: finite, no brighter than the light that
/// there is, and drawn to the end.
void expectSane(const std::string& what, const std::string& preset, const TransferFunction* function,
                const Lighting& lighting) {
    SCOPED_TRACE(what + ", " + preset);
    Scene scene = sceneOn(infoOf("sphere"), preset, 0, {10, 10});
    if (function)
        scene.volumes[0].transferFunction = *function;
    scene.lighting = lighting;
    Prepared prepared("sphere", scene);
    prepared.p.view.shadowQuality.mapSize = 32;
    const double most = 1.5 * std::max(1.0, maxIncidentLight(lighting.lights)) *
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
        expectSane("a light inside", "bone-1", function, pointAt(glm::dvec3(info.extentVoxels) * 0.45, 0));
        expectSane("a large one inside", "bone-1", function,
                   pointAt(glm::dvec3(info.extentVoxels) * 0.45, 90));
        expectSane("on a corner of bricks", "bone-1", function, pointAt({32, 32, 32}, 0));
        expectSane("behind bone", "bone-1", function, pointAt({-9, 200, 25}, 0));
        expectSane("without a direction", "bone-1", function, without);
        expectSane("a radius beyond the volume", "bone-1", function, far);
    }
}

} // namespace
} // namespace tessera::test

// tests/render/light/emission_test.cpp: tissue that sends light: what is seen of it, what it lights, and that
// both cost nothing where nothing does.
#include "core/base/error.h"
#include "core/scene/preset.h"
#include "render/light/directions.h"
#include "render/light/scene_light.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/reference_light.h"
#include "tests/support/surface_fixture.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

const glm::dvec3 kGlow(1, 0.5, 0.25);

/// Soft tissue whose bone sends light.
TransferFunction glowing() {
    TransferFunction function = presetFunction("soft-tissue", {-1000, 2000, true, 1, {}});
    function.setMaterials({{-1000, 163.3, 0.2, 0.7, 0.2, 12}, {163.3, 3000, 0.3, 0.6, 0.2, 20, kGlow}});
    return function;
}
Scene glowingScene(const Lighting& lighting, int camera = 0, const glm::ivec2& size = {24, 24}) {
    Scene scene = sceneOn(infoOf("torso"), "soft-tissue", camera, size);
    scene.volumes[0].transferFunction = glowing();
    scene.lighting = lighting;
    return scene;
}
Lighting lightOfTissue(double emission = 12) {
    Lighting lighting;
    lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6, .emission = emission};
    lighting.lights = {keyLight(), Light{}};
    return lighting;
}

Image mirrorOf(Prepared& prepared, const RaySource<float>& rays, std::size_t count) {
    const FramePlan& p = prepared.p;
    MirrorInput input = mirrorInput(p, true);
    std::optional<SceneLight> light;
    std::optional<StoredLight> stored;
    if (lightChannels(p.view.lighting) > 0) {
        light.emplace(p, 0);
        stored.emplace(*light, p, prepared.budgets.ram);
        input.light = &*stored;
    }
    Image image(p.view.imageSize);
    Work work;
    image.pixels = mirrorRays<float>(input, count, rays, 0, work);
    return image;
}

/// With all light, and seen alone, without any that lights others.
TEST(Emission, EnginesAgree) {
    const GlContext context({"software"});
    int n = 0;
    for (const bool gathered : {true, false})
        for (const bool mixed : {false, true})
            for (const bool surfaces : {false, true}) {
                Scene scene = glowingScene(gathered ? lightOfTissue() : Lighting(), 2 * (n++ % 2));
                scene.quality.integrator = mixed ? Integrator::midpoint : Integrator::preintegrated;
                if (surfaces)
                    scene.surfaces = {{300, {1, 0.9, 0.8}, 0.7}};
                Prepared prepared("torso", scene);
                Planner& p = prepared.p;
                p.view.shadowQuality.mapSize = 64;
                if (mixed)
                    p.setSelection(randomShownLevels(p.layer().selection, 5));
                const std::string what = std::string(gathered ? "gathered" : "seen") +
                                         (mixed ? ", mixed levels" : "") + (surfaces ? ", a surface" : "");
                const std::size_t count = rayCount(p.view.imageSize);
                const Image mirror = mirrorOf(prepared, frameRays(cast<float>(p.view.frame)), count);
                for (const native::PacketTarget* target : nativeTargets()) {
                    NativeChoices choices;
                    choices.target = target;
                    EXPECT_EQ(differing(nativePicture(prepared, choices).image, mirror), 0u)
                        << what << ", " << target->name;
                }
                const auto difference = [&](Prepared& drawn) {
                    const std::vector<SegmentedRay<float>> rays =
                        gpuRays(drawn.p.view.frame, drawn.budgets.gpu);
                    const Image same = mirrorOf(
                        drawn, [&](std::size_t i) { return rays[i]; }, count);
                    return compare(marchOn(drawn, kFeatureSkipping | kFeatureShading).image, same).maxAbs;
                };
                if (const double found = difference(prepared); found > 5e-5) {
                    // A ray of the phantom that grazes the surface. Rounding moves its crossing, with or
                    // without emission, which makes the picture up to three times as bright.
                    TransferFunction dark = glowing();
                    std::vector<Material> materials = dark.materials();
                    for (Material& m : materials)
                        m.emission = glm::dvec3(0);
                    dark.setMaterials(materials);
                    scene.volumes[0].transferFunction = dark;
                    Prepared without("torso", scene);
                    without.p.view.shadowQuality.mapSize = 64;
                    const double least = difference(without);
                    tell("%s: %.3g, without emission %.3g\n", what.c_str(), found, least);
                    EXPECT_LT(found, 3 * least) << what;
                    EXPECT_TRUE(surfaces && !mixed) << what;
                }
            }
}

/// Tissue that reflects nothing shows its emission alone.
TEST(Emission, IsSeenAsItIs) {
    for (const Integrator integrator : {Integrator::midpoint, Integrator::preintegrated2d}) {
        Scene scene = glowingScene({});
        TransferFunction function = glowing();
        function.setMaterials({{-2000, 4000, 0, 0, 0, 1, kGlow}});
        scene.volumes[0].transferFunction = function;
        scene.quality.integrator = integrator;
        Prepared prepared("torso", scene);
        double seen = 0;
        for (const Image& image :
             {nativePicture(prepared).image, referencePicture(referenceInput(prepared, scene), prepared)})
            for (const glm::vec4& p : image.pixels) {
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(p[c], p.a * static_cast<float>(kGlow[c]), 2e-6);
                seen += static_cast<double>(p.a);
            }
        EXPECT_GT(seen, 10);
    }
}

/// Tissue's emission gets as far as light from all sides does. In one medium both are the open share of the
/// way through it, in the reference.
TEST(Emission, OfOneMediumInTheReference) {
    const Stored stored([](const glm::dvec3& p) { return p.x; });
    const glm::dvec3 place(22.3, 19.1, 24.7), extent(stored.info.extentVoxels);
    double most = 0;
    for (const double tau : {1e-4, 0.1, 1.0, 30.0})
        for (const double radius : {9.0, 1000.0}) {
            TransferFunction function = TransferFunction::fromExtinction({{0, tau}}, {});
            function.setMaterials({{-100, 30, 0.2, 0.8, 0.2, 20}, {30, 1000, 0.2, 0.8, 0.2, 20, kGlow}});
            Scene scene = stored.scene({});
            scene.volumes[0].transferFunction = function;
            scene.lighting.occlusion = Occlusion{.rays = 32, .radiusMm = radius, .emission = 3};
            const auto prepared = stored.prepare(scene);
            RaysOfLight rays(*prepared, scene);
            ASSERT_EQ(rays.light.channels(), 3);
            GatheredLight sum;
            for (const auto& [towards, part] : sphereDirections(32)) {
                const glm::dvec3 along = rays.voxelsPerMm(towards);
                double border = radius;
                for (int axis = 0; axis < 3; ++axis)
                    if (std::abs(along[axis]) > 1e-12)
                        border = std::min(border,
                                          ((along[axis] > 0 ? extent[axis] : 0) - place[axis]) / along[axis]);
                // From x = 30 on it sends light.
                const double from = along.x > 1e-12 ? std::min(border, (30 - place.x) / along.x) : border;
                const double sent = (std::exp(-tau * from) - std::exp(-tau * border)) / tau / radius;
                const GatheredLight light = rays.light.gathered(rays.patient(place), towards);
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(light.sent[c], kGlow[c] * sent, 1e-6) << tau << ", " << radius;
                sum.open += part * light.open;
                sum.sent += part * light.sent;
            }
            const LightShares shares = rays.light.at(place);
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(shares[static_cast<std::size_t>(c)],
                            std::pow(0.1 + sum.open + 3 * sum.sent[c], 0.6), 1e-12);
            most = std::max(most, sum.sent.r);
        }
    EXPECT_GT(most, 0.02);
}

/// Tissue's light brightens its surroundings in its colour, the more the stronger it is.
TEST(Emission, LightsWhatIsAround) {
    const auto brightness = [](double emission) {
        Prepared prepared("torso", glowingScene(lightOfTissue(emission)));
        prepared.p.view.shadowQuality.mapSize = 64;
        glm::dvec4 sum(0);
        for (const glm::vec4& p : nativePicture(prepared).image.pixels)
            sum += glm::dvec4(p);
        return sum;
    };
    const glm::dvec4 none = brightness(0), some = brightness(10), more = brightness(20);
    EXPECT_EQ(none.a, more.a);
    EXPECT_GT(some.r, 1.01 * none.r);
    EXPECT_GT(more.r, some.r);
    EXPECT_GT(some.r / none.r, 1.005 * some.b / none.b);
}

/// Bytes, channels and pictures of a scene whose function sends no light are those of one without emission.
TEST(Emission, CostsNothingWhereNothingSendsLight) {
    Scene asked = glowingScene(lightOfTissue()), without = glowingScene(lightOfTissue(0));
    TransferFunction dark = presetFunction("soft-tissue", {-1000, 2000, true, 1, {}});
    dark.setMaterials({{150, 3000, 0.3, 0.6, 0.2, 20}});
    asked.volumes[0].transferFunction = without.volumes[0].transferFunction = dark;
    Prepared a("torso", asked), b("torso", without);
    a.p.view.shadowQuality.mapSize = b.p.view.shadowQuality.mapSize = 64;
    EXPECT_EQ(lightChannels(a.p.view.lighting), 2);
    const NativePicture one = nativePicture(a), other = nativePicture(b);
    EXPECT_EQ(differing(one.image, other.image), 0u);
    EXPECT_EQ(one.work.bytesUploaded, other.work.bytesUploaded);
    EXPECT_EQ(a.budgets.gpu.peakBytes(), b.budgets.gpu.peakBytes());
    EXPECT_EQ(a.budgets.ram.peakBytes(), b.budgets.ram.peakBytes());
    const Prepared shines("torso", glowingScene(lightOfTissue()));
    EXPECT_EQ(lightChannels(shines.p.view.lighting), 4);
}

TEST(Emission, IsRefusedWhereRaysLookAtTheirEndAlone) {
    Lighting lighting = lightOfTissue();
    lighting.occlusion->method = OcclusionMethod::positional;
    try {
        const Prepared prepared("torso", glowingScene(lighting));
        FAIL() << "drawn";
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("lighting.occlusion"));
        EXPECT_THAT(error.what(), HasSubstr("emission"));
    }
}

} // namespace
} // namespace tessera::test

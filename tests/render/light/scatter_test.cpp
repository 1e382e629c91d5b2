// tests/render/light/scatter_test.cpp: light that tissue scatters to its surroundings: closed forms, the
// contract written out once more, engines, changes, refusals, and scenes without it, which pay nothing.
#include "core/base/error.h"
#include "core/scene/preset.h"
#include "render/light/directions.h"
#include "render/light/light_memory.h"
#include "render/light/scatter_light.h"
#include "render/light/scene_light.h"
#include "render/picture/render_scene.h"
#include "tests/support/lit_picture.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/paths_and_kept.h"
#include "tests/support/reference_light.h"
#include "tests/support/refusals.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <utility>

namespace tessera::test {
namespace {

using testing::HasSubstr;

Light scattered(double scatter = 2, double softness = 0) {
    Light light = keyLight(softness);
    light.scatter = scatter;
    return light;
}
Lighting scatteredAlone(double radiusMm = 6) {
    Lighting lighting;
    lighting.lights = {scattered(), Light{}};
    lighting.scatterRadiusMm = radiusMm;
    return lighting;
}

/// Ambient light of samples of a formula, as engines keep it.
struct LitFormula {
    LitFormula(const Formula& value, const TransferFunction& function, const Lighting& lighting,
               const glm::ivec3& extent = glm::ivec3(64))
        : stored(value, extent, true) {
        Scene scene = stored.scene({});
        scene.volumes[0].transferFunction = function;
        scene.lighting = lighting;
        prepared = stored.prepare(scene);
        prepared->p.view.shadowQuality.mapSize = 64;
        light.emplace(prepared->p, 0);
        texels.emplace(*light, prepared->p, prepared->budgets.ram);
    }
    glm::dvec3 at(const glm::ivec3& sample) const {
        glm::dvec3 found;
        for (int c = 0; c < 3; ++c)
            found[c] = StoredLight::Channel(*texels, c).at(0, sample) / double{leaf::kLightOne};
        return found;
    }
    Stored stored;
    std::unique_ptr<Prepared> prepared;
    std::optional<SceneLight> light;
    std::optional<StoredLight> texels;
};

/// I_s = c (1 - e^(-tau R)) / (tau R), where light gets everywhere.
TEST(Scatter, OfAnEvenMediumIsItsClosedForm) {
    const glm::dvec3 colour(0.9, 0.5, 0.2);
    for (const double tau : {1e-4, 0.02, 0.1})
        for (const double radius : {16.0, 24.0}) {
            Light everywhere;
            everywhere.kind = LightKind::directional;
            everywhere.scatter = 1;
            Lighting lighting;
            lighting.lights = {everywhere};
            lighting.scatterRadiusMm = radius;
            const LitFormula lit([](const glm::dvec3&) { return 1.0; },
                                 TransferFunction::fromExtinction(
                                     {{0, tau}, {2, tau}}, {{0, glm::vec3(colour)}, {2, glm::vec3(colour)}}),
                                 lighting);
            const double share = -std::expm1(-tau * radius) / (tau * radius);
            const glm::dvec3 found = lit.at({32, 31, 33});
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c], 1 + colour[c] * share, 1e-3) << tau << ", " << radius;
        }
}

/// A wall beside a lit red sphere takes red light, until the sphere is in the shade, or is not drawn.
TEST(Scatter, BringsTheColourOfWhatIsLit) {
    const Formula sphere = [](const glm::dvec3& p) {
        return p.x > 40 ? 1.0 : glm::length(p - glm::dvec3(28, 32, 32)) < 10 ? 2.0 : p.z > 50 ? 3.0 : 0.0;
    };
    const auto wall = [&](double ofSphere, double ofLid, const glm::dvec3& towards) {
        Lighting lighting;
        lighting.lights = {scattered(1)};
        lighting.lights[0].direction = towards;
        lighting.scatterRadiusMm = 12;
        const LitFormula lit(
            sphere,
            TransferFunction::fromExtinction(
                {{0.4, 0}, {0.6, 10}, {1.4, 10}, {1.6, ofSphere}, {2.4, ofSphere}, {2.6, ofLid}, {3, ofLid}},
                {{1, {1, 1, 1}}, {1.4, {1, 1, 1}}, {1.6, {1, 0, 0}}, {2.4, {1, 0, 0}}, {2.6, {1, 1, 1}}}),
            lighting);
        return lit.at({39, 32, 32}) - 1.0;
    };
    const glm::dvec3 up(0, 0, 1);
    const glm::dvec3 red = wall(10, 0, up), none = wall(0, 0, up), shaded = wall(10, 50, up);
    EXPECT_GT(red.r, red.g + 0.002);
    EXPECT_NEAR(red.g, red.b, 1e-4);
    EXPECT_NEAR(none.r, none.g, 1e-4);
    EXPECT_LT(shaded.r - shaded.g, 0.2 * (red.r - red.g)) << "the sphere is below the lid";
}

/// The contract in double, without lanes: docs/sampling.md, "Scattered light".
class Plainly {
  public:
    Plainly(const FramePlan& p, std::span<const ShadowMaps> maps, int level)
        : p_(p), maps_(maps), level_(level), samples_(*p.layer().cache, p.info(), level, nullptr) {}

    glm::dvec3 at(const glm::ivec3& sample) {
        const Lighting& lighting = p_.view.lighting;
        const glm::dmat3 voxels = glm::inverse(glm::dmat3(p_.info().patientFromVoxel));
        glm::dvec3 sum(0);
        for (const auto& [direction, part] : sphereDirections(32)) {
            const glm::dvec3 along = voxels * direction;
            const double steepest = std::max({std::abs(along.x), std::abs(along.y), std::abs(along.z)});
            const double stepMm = std::ldexp(1 / steepest, level_);
            const double steps = std::max(1.0, std::min(32.0, std::round(lighting.scatterRadiusMm / stepMm)));
            double through = 1;
            glm::dvec3 sent(0);
            for (double n = 0; n <= steps; ++n) {
                const glm::dvec3 place = glm::dvec3(sample) + n * along / steepest;
                double taken = 0;
                glm::dvec3 here(0);
                between(place, [&](const glm::ivec3& i, double weight) {
                    const double tau = extinction(i);
                    taken -= weight * std::expm1(-tau * stepMm);
                    if (tau > 0)
                        here += weight * glm::dvec3(lookUp(p_.layer().optics, double(samples_.at(i)))) *
                                lightAt(i);
                });
                const double half = n == 0 || n == steps ? 0.5 : 1;
                const double after = through * std::pow(1 - taken, half);
                sent += half * (through + after) / 2 * here;
                through = after;
            }
            sum += part * sent / steps;
        }
        return sum;
    }

  private:
    double extinction(const glm::ivec3& i) {
        const bool outside = glm::any(glm::lessThan(i, glm::ivec3(0))) ||
                             glm::any(glm::greaterThanEqual(i, samples_.extent()));
        return outside ? 0 : occlusionExtinction(p_.layer().optics, double(samples_.at(i)));
    }
    template <typename Visit> static void between(const glm::dvec3& place, const Visit& visit) {
        const glm::ivec3 low(glm::floor(place));
        for (int n = 0; n < 8; ++n) {
            const glm::ivec3 corner(n & 1, (n >> 1) & 1, n >> 2);
            const glm::dvec3 weights = 1.0 - glm::abs(place - glm::dvec3(low + corner));
            if (const double weight = weights.x * weights.y * weights.z; weight > 1e-12)
                visit(low + corner, weight);
        }
    }
    glm::dvec3 lightAt(const glm::ivec3& i) {
        const glm::dvec3 place(p_.info().patientFromVoxel *
                               glm::dvec4((glm::dvec3(i) + 0.5) * std::ldexp(1.0, level_), 1));
        glm::dvec3 sum(0);
        std::size_t caster = 0;
        for (const Light& light : p_.view.lighting.lights) {
            double left = light.shadow ? double{maps_[caster++].light(place, level_)} : 1;
            if (light.kind == LightKind::point) {
                const double mm = glm::length(light.position - place);
                left /= light.attenuation.x + light.attenuation.y * mm + light.attenuation.z * mm * mm;
            }
            sum += light.scatter * light.intensity * left * light.colour;
        }
        return sum;
    }

    const FramePlan& p_;
    std::span<const ShadowMaps> maps_;
    int level_;
    LatticeReader samples_;
};

/// Coloured lights of every kind, one with a shadow, through a phantom of tissues.
TEST(Scatter, IsWhatTheContractSays) {
    const VolumeInfo info = infoOf("torso");
    Light lamp; // before the chest
    lamp.kind = LightKind::point;
    lamp.frame = LightFrame::patient;
    lamp.position = glm::dvec3(info.patientFromVoxel * glm::dvec4(30, -40, 30, 1));
    lamp.attenuation = {0.5, 0.004, 0.0001};
    lamp.colour = {0.3, 0.6, 1};
    lamp.scatter = 0.8;
    for (const bool point : {false, true})
        for (const int level : {0, 1}) {
            Scene scene = sceneOn(info, "soft-tissue", 0, {16, 16});
            scene.lighting.lights = {scattered(1.5), lamp, Light{}};
            scene.lighting.lights[0].colour = {1, 0.8, 0.6};
            if (point)
                scene.lighting.lights[0] = lamp, scene.lighting.lights[0].shadow = true;
            scene.lighting.scatterRadiusMm = 7;
            scene.lighting.finestLevel = level;
            Prepared prepared("torso", scene);
            FramePlan& p = prepared.p;
            p.view.shadowQuality.mapSize = 64;
            SceneLight light(p, 0);
            const StoredLight texels(light, p, prepared.budgets.ram);
            VoxelLight& voxels = light.ready();
            Plainly plainly(p, light.shadows(), level);
            const glm::ivec3 extent = levelExtent(info.extentVoxels, level);
            std::size_t compared = 0;
            double sum = 0;
            std::vector<BrickToLight> bricks;
            for (std::size_t b = 0; b < cellCount(brickGrid(info.extentVoxels)); ++b)
                bricks.push_back({b, level, level});
            const std::vector<std::uint8_t> expected(bricks.size(), static_cast<std::uint8_t>(level));
            voxels.light(bricks, expected, kAmbientLight, *p.layer().cache,
                         [&](const BrickToLight& b, int channel, const Chunk& chunk, int edge) {
                             const auto* const all =
                                 reinterpret_cast<const std::uint16_t*>(chunk.bytes.get());
                             const glm::ivec3 first =
                                 gridPosition(b.brick, brickGrid(info.extentVoxels)) * edge;
                             for (std::size_t n = 5; n < cellCount(glm::ivec3(edge)); n += 701) {
                                 const glm::ivec3 at = gridPosition(n, glm::ivec3(edge));
                                 const double found =
                                     all[linearIndex(at, glm::ivec3(kChunkExtent))] / double{leaf::kLightOne};
                                 if (!glm::all(glm::lessThan(first + at, extent)) || found == 1)
                                     continue; // nothing shows there
                                 const double scatter = plainly.at(first + at)[channel];
                                 ASSERT_NEAR(found, 1 + scatter, 4e-4) << level << ", " << channel;
                                 ++compared;
                                 sum += scatter;
                             }
                         });
            EXPECT_GT(compared, 100u);
            EXPECT_GT(sum, 0.01 * static_cast<double>(compared));
        }
}

/// Alone and beside every kind of ambient light, with surfaces, one level and mixed.
TEST(Scatter, EnginesAgree) {
    const GlContext context({"software"});
    int n = 0;
    for (const int beside : {0, 1, 2, 3})
        for (const bool mixed : beside == 0 ? std::vector{false, true} : std::vector{beside != 1}) {
            Lighting lighting = scatteredAlone();
            if (beside > 0)
                lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6};
            if (beside == 1)
                lighting.lights = {scattered(1, 6)};
            if (beside == 2)
                lighting.occlusion->method = OcclusionMethod::histogram;
            if (beside == 3)
                lighting.occlusion->emission = 5;
            Scene scene = sceneOn(infoOf("torso"), "soft-tissue", n++ % 3, {24, 24});
            scene.lighting = lighting;
            scene.quality.integrator = mixed ? Integrator::midpoint : Integrator::preintegrated;
            if (beside == 1)
                scene.surfaces = {{300, {1, 0.9, 0.8}, 0.7}};
            if (beside == 3) {
                TransferFunction function = presetFunction("soft-tissue", {-1000, 2000, true, 1, {}});
                function.setMaterials({{163.3, 3000, 0.3, 0.6, 0.2, 20, {1, 0.5, 0.25}}});
                scene.volumes[0].transferFunction = function;
            }
            Prepared prepared("torso", scene);
            Planner& p = prepared.p;
            p.view.shadowQuality.mapSize = 64;
            if (mixed)
                p.setSelection(randomShownLevels(p.layer().selection, 3));
            const Image mirror = mirrorLit(prepared);
            for (const native::PacketTarget* target : nativeTargets()) {
                NativeChoices choices;
                choices.target = target;
                EXPECT_EQ(differing(nativePicture(prepared, choices).image, mirror), 0u)
                    << beside << ", " << target->name;
            }
            NativeChoices one;
            one.threads = 1;
            EXPECT_EQ(differing(nativePicture(prepared, one).image, mirror), 0u);
            if (beside != 0 || !mixed)
                continue;
            const std::vector<SegmentedRay<float>> rays = gpuRays(p.view.frame, prepared.budgets.gpu);
            const Image same = mirrorLit(prepared, [&](std::size_t i) { return rays[i]; });
            EXPECT_LT(compare(marchOn(prepared, kFeatureSkipping | kFeatureShading).image, same).maxAbs,
                      5e-5);
        }
}

/// Scattered light grows with its factor, and comes on top of all else that is ambient.
TEST(Scatter, IsLinearInItsLight) {
    const auto ambient = [](double scatter, double intensity, bool occludes) {
        Lighting lighting = scatteredAlone();
        lighting.lights[0].scatter = scatter;
        lighting.lights[0].intensity = intensity;
        lighting.lights[0].colour = {1, 0.5, 0.25};
        if (occludes)
            lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6, .emission = scatter > 0 ? 0.0 : 1e-9};
        TransferFunction function = TransferFunction::fromExtinction({{0, 0.002}, {60, 0.02}}, {});
        function.setMaterials({{-10, 100, 0.2, 0.8, 0.2, 20, {1, 1, 1}}});
        return LitFormula([](const glm::dvec3& p) { return p.x; }, function, lighting).at({30, 30, 30});
    };
    const glm::dvec3 one = ambient(1, 1, false) - 1.0, two = ambient(2, 1, false) - 1.0,
                     half = ambient(1, 0.5, false) - 1.0, open = ambient(0, 1, true),
                     both = ambient(1, 1, true);
    ASSERT_GT(one.r, 0.01);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(two[c], 2 * one[c], 2e-4);
        EXPECT_NEAR(half[c], 0.5 * one[c], 2e-4);
        EXPECT_NEAR(both[c], open[c] + one[c], 2e-4);
    }
    EXPECT_NEAR(one.g, 0.5 * one.r, 2e-4);
}

/// Lit from one side, pictures with scattered light are nearer to those by paths of up to 64 scatterings.
/// TESSERA_TELL=1 tells of factors and radii; TESSERA_SCATTER_STORE=a.zarr of another store.
TEST(Scatter, IsNearerToPaths) {
    const char* const other = std::getenv("TESSERA_SCATTER_STORE");
    const bool tells = std::getenv("TESSERA_TELL") != nullptr;
    Light side = keyLight();
    side.direction = {-1, -0.2, 0.2};
    for (const char* preset : {"soft-tissue", "bone-1"}) {
        PathsAndKept pictures(other ? other : storePath("torso").string(), preset, side, tells ? 128 : 32, 8);
        const double without = pictures.rms(0);
        tell("%s: rms of what further scatterings add %.4f; of all light %.4f\n", preset, without,
             pictures.rms(0, true));
        for (const double radius : tells ? std::vector<double>{2, 4, 8, 16} : std::vector<double>{4}) {
            pictures.scatter([&](Lighting& lighting) { lighting.scatterRadiusMm = radius; });
            double least = without, best = 0;
            for (double scatter = 0.05; scatter <= 4; scatter += 0.05)
                if (const double with = pictures.rms(scatter); with < least)
                    least = with, best = scatter;
            tell("    radius %g: with %.4f (%.2f), half %.4f, double %.4f, best %g times %.4f (%.2f); of all "
                 "%.4f\n",
                 radius, pictures.rms(1), pictures.rms(1) / without, pictures.rms(0.5), pictures.rms(2), best,
                 least, least / without, pictures.rms(1, true));
            std::fflush(stdout);
            EXPECT_LT(least, 0.9 * without) << preset;
        }
    }
}

/// Lights without "scatter", and those that do not shine, leave bytes, channels and bits as they are.
TEST(Scatter, CostsNothingWhereItIsNotAskedFor) {
    Scene without = sceneOn(infoOf("torso"), "soft-tissue", 0, {24, 24});
    without.lighting.lights = {keyLight(), Light{}};
    without.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6};
    Scene with = without;
    with.lighting.scatterRadiusMm = 30;
    with.lighting.scatterBy = ScatterSource::map;
    with.lighting.lightMap.size = 192;
    with.lighting.lights.push_back(scattered());
    with.lighting.lights.back().intensity = 0;
    Prepared a("torso", without), b("torso", with);
    EXPECT_EQ(lightChannels(b.p.view.lighting), 2);
    const NativePicture one = nativePicture(a), other = nativePicture(b);
    EXPECT_EQ(differing(one.image, other.image), 0u);
    EXPECT_EQ(one.work.bytesUploaded, other.work.bytesUploaded);
    EXPECT_EQ(a.budgets.gpu.peakBytes(), b.budgets.gpu.peakBytes());
    EXPECT_EQ(a.budgets.ram.peakBytes(), b.budgets.ram.peakBytes());
    with.lighting.lights.pop_back();
    with.lighting.lights[0].scatter = 1;
    with.lighting.scatterBy = ScatterSource::rays;
    const Prepared scatters("torso", with);
    EXPECT_EQ(lightChannels(scatters.p.view.lighting), 4);
    const auto bytes = [](const Prepared& p) {
        return lightRamBytes(p.p.view.lighting, p.p.info(), p.p.view.shadowQuality, 2, false, false);
    };
    EXPECT_GE(bytes(scatters), bytes(a) + ScatterLight::bytes(a.p.info(), with.lighting, 2));
}

TEST(Scatter, RefusesWhatItDoesNotGoWith) {
    const Scene plain = [] {
        Scene scene = sceneOn(infoOf("torso"), "bone-1", 0, {24, 24});
        scene.lighting = scatteredAlone();
        return scene;
    }();
    const std::pair<std::function<void(Scene&)>, const char*> refused[] = {
        {[](Scene& s) { s.volumes[0].labels.path = "labels.nii"; }, "no labels"},
        {[](Scene& s) { s.volumes.push_back(s.volumes[0]); }, "one volume"},
        {[](Scene& s) {
             s.lighting.surfaceOcclusion.emplace();
             s.mode = Mode::isosurface;
             s.surfaces = {{300, {1, 1, 1}, 1}};
         },
         "no surfaceOcclusion"},
        {[](Scene& s) {
             s.lighting.transport = Transport{TransportResponse::contract};
             s.quality.pixels.samples = 1;
         },
         "response \"contract\""},
    };
    for (const auto& [change, expected] : refused) {
        Scene scene = plain;
        change(scene);
        EXPECT_THAT(refusalOf([&] { const Prepared prepared("torso", scene); }), HasSubstr(expected));
    }
    // Of single values there is no light.
    Scene values = plain;
    values.mode = Mode::maximum;
    EXPECT_EQ(refusalOf([&] { const Prepared prepared("torso", values); }), "no refusal");
    // Paths scatter light themselves.
    Scene paths = plain;
    paths.lighting.transport.emplace();
    paths.quality.pixels.samples = 1;
    EXPECT_EQ(lightChannels(Prepared("torso", paths).p.view.lighting), 0);
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
    const StoreReader reader(storePath("torso"), ram);
    RenderOptions options;
    options.engine = EngineKind::reference;
    EXPECT_THAT(refusalOf([&] { renderScene(plain, reader, ram, gpu, options); }), HasSubstr("scattered"));
}

} // namespace
} // namespace tessera::test

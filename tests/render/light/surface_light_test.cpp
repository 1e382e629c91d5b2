// tests/render/light/surface_light_test.cpp: ambient occlusion of isosurfaces from the first hits of rays:
// closed forms, pictures, refusals, and no cost where it is off.
#include "core/base/error.h"
#include "render/backends/mirror/mirror_surfaces.h"
#include "render/backends/reference/surface_rays.h"
#include "render/light/directions.h"
#include "render/light/surface_light.h"
#include "render/picture/render_scene.h"
#include "tests/support/native_fixture.h"
#include "tests/support/occluded_surfaces.h"
#include "tests/support/reference_light.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <span>
#include <vector>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

TEST(SurfaceLight, DirectionsAreSpreadByTheCosine) {
    for (const glm::dvec3& n : {glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1), glm::dvec3(0.6, -0.8, 0),
                                glm::normalize(glm::dvec3(1, 2, -3))})
        for (const int count : {1, 7, 16, 256}) {
            const auto directions = hemisphereDirections(n, count, hemisphereKey({12.5f, 7.5f}, 3));
            ASSERT_EQ(directions.size(), static_cast<std::size_t>(count));
            for (int k = 0; k < count; ++k) {
                const glm::dvec3& d = directions[static_cast<std::size_t>(k)];
                EXPECT_NEAR(glm::length(d), 1, 1e-12);
                const double squared = 1 - glm::dot(d, n) * glm::dot(d, n); // of the disk's radius
                EXPECT_GE(squared, static_cast<double>(k) / count - 1e-12);
                EXPECT_LE(squared, static_cast<double>(k + 1) / count + 1e-12);
            }
        }
    // A half space at any tilt is as open as the cosine says: (1 + cos)/2. By 16 directions, over many keys.
    const glm::dvec3 n(0, 0, 1);
    for (const double tilt : {0.3, 0.9, 1.4}) {
        const glm::dvec3 side(std::sin(tilt), 0, std::cos(tilt));
        double sum = 0;
        constexpr int kKeys = 2000;
        for (int k = 0; k < kKeys; ++k)
            for (const glm::dvec3& d :
                 hemisphereDirections(n, 16, hemisphereKey({static_cast<float>(k), 0.5f}, 0)))
                sum += glm::dot(d, side) > 0 ? 1.0 / 16 / kKeys : 0;
        EXPECT_NEAR(sum, (1 + std::cos(tilt)) / 2, 2e-3) << tilt;
    }
    EXPECT_NE(hemisphereKey({1.5f, 2.5f}, 0), hemisphereKey({2.5f, 1.5f}, 0));
    EXPECT_NE(hemisphereKey({1.5f, 2.5f}, 0), hemisphereKey({1.5f, 2.5f}, 1));
}

/// A floor at z = 10 with a wall at x = 10, all of it solid that is below either, in mm as in voxels.
Scene corner(const Stored& stored, const SurfaceOcclusion& occlusion) {
    Scene scene = stored.scene({{0, glm::dvec3(1), 1}});
    scene.lighting.surfaceOcclusion = occlusion;
    scene.shading.ambient = 0.8, scene.shading.diffuse = 0.2, scene.shading.specular = 0;
    return scene;
}
Formula cornerField() {
    return [](const glm::dvec3& p) { return std::min(p.x - 10, p.z - 10); };
}
SurfaceHit onFloor(double x) {
    SurfaceHit hit;
    hit.position = glm::vec3(static_cast<float>(x), 20, 10);
    hit.normal = glm::vec3(0, 0, 1);
    hit.surface = 1;
    return hit;
}
/// Of the place a voxel above the floor, by so many directions as make no difference.
double cornerOpen(double x, double radius) {
    double open = 0;
    constexpr int kAngles = 400, kRings = 400;
    for (int a = 0; a < kAngles; ++a)
        for (int r = 0; r < kRings; ++r) {
            const double angle = 2 * std::numbers::pi * (a + 0.5) / kAngles, squared = (r + 0.5) / kRings;
            const double along = std::sqrt(squared) * std::cos(angle);
            const double mm = along < 0 ? (10 - x) / along : radius;
            open += std::min(mm, radius) / radius / kAngles / kRings;
        }
    return open;
}

TEST(SurfaceLight, ACornerIsAsDarkAsItsFormula) {
    const Stored stored(cornerField(), glm::ivec3(40), true);
    for (const double radius : {4.0, 12.0}) {
        const auto prepared =
            stored.prepare(corner(stored, {.rays = SurfaceOcclusion::kMostRays, .radiusMm = radius}));
        const SurfaceLight light(prepared->p, 0);
        const MirrorTracer tracer(prepared->p, SurfaceLight::kSegmentVoxels);
        for (const double x : {11.0, 12.5, 16.0, 21.9, 25.0}) {
            const double truth = cornerOpen(x, radius);
            double sum = 0;
            for (int k = 0; k < 16; ++k)
                sum += static_cast<double>(
                           light.openAt(onFloor(x), {static_cast<float>(k) + 0.5f, 3.5f}, tracer)) /
                       16;
            EXPECT_NEAR(sum, truth, 1.5e-3) << x << " of " << radius;
            EXPECT_TRUE(x <= 10 + radius || sum == 1);
        }
    }
}

/// Parts that are cut away occlude nothing. If two cuts leave two parts of a ray, both count.
TEST(SurfaceLight, CutsOpen) {
    const Stored stored(cornerField(), glm::ivec3(40), true);
    const auto openOf = [&](const Cuts& cuts) {
        Scene scene = corner(stored, {.rays = SurfaceOcclusion::kMostRays, .radiusMm = 12});
        scene.cuts = cuts;
        const auto prepared = stored.prepare(scene);
        return static_cast<double>(SurfaceLight(prepared->p, 0)
                                       .openAt(onFloor(12.5), {0.5f, 0.5f},
                                               MirrorTracer(prepared->p, SurfaceLight::kSegmentVoxels)));
    };
    const double whole = openOf({});
    EXPECT_NEAR(whole, cornerOpen(12.5, 12), 6e-3);
    Cuts kept, wall, gap;
    kept.boxes = {{{0, 0, 0}, {40, 40, 40}, CropBox::Space::voxels, Keep::inside}};
    EXPECT_EQ(openOf(kept), whole);
    wall.boxes = {{{11, 0, 0}, {40, 40, 40}, CropBox::Space::voxels, Keep::inside}}; // the wall is cut off
    EXPECT_EQ(openOf(wall), 1);
    gap.boxes = {{{10.5, 0, 0}, {11.5, 40, 40}, CropBox::Space::voxels, Keep::outside}}; // air before it
    EXPECT_NEAR(openOf(gap), whole, 1e-5);
}

/// Two sheets of glass in the way take what is left, one after the other.
TEST(SurfaceLight, GlassLetsSomeThrough) {
    const Stored stored(
        [](const glm::dvec3& p) { return std::abs(std::abs(p.z - 20) - 6) - 2; }, // 12..16, 24..28
        glm::ivec3(40), true);
    Scene scene = stored.scene({{0, glm::dvec3(1), 0.25}});
    scene.lighting.surfaceOcclusion = SurfaceOcclusion{.rays = 64, .radiusMm = 6};
    const auto prepared = stored.prepare(scene);
    SurfaceHit hit;
    hit.position = {20, 20, 28};
    hit.normal = {0, 0, -1}; // into the sheet: its other side is 3 away, and one more 8 behind that
    hit.surface = 1;
    const MirrorTracer tracer(prepared->p, SurfaceLight::kSegmentVoxels);
    double sum = 0;
    for (int k = 0; k < 64; ++k)
        sum += static_cast<double>(
                   SurfaceLight(prepared->p, 0).openAt(hit, {static_cast<float>(k) + 0.5f, 0.5f}, tracer)) /
               64;
    // A direction at the cosine c meets it at 3/c, where a quarter goes.
    double truth = 0;
    constexpr int kParts = 100000;
    for (int k = 0; k < kParts; ++k) {
        const double c = std::sqrt((k + 0.5) / kParts);
        truth += (1 - 0.25 * std::max(0.0, 1 - 3 / c / 6)) / kParts;
    }
    EXPECT_NEAR(sum, truth, 2e-3);
}

/// A flat surface in an even medium: the medium before it counts twice, on the way to the eye and around the
/// place.
TEST(SurfaceLight, AnEvenMediumTakesWhatItsClosedFormSays) {
    const Stored stored([](const glm::dvec3& p) { return p.z - 20; }, glm::ivec3(40), true);
    for (const double extinction : {0.01, 0.3}) {
        Scene scene = stored.scene({{0, glm::dvec3(0.5, 0.6, 0.7), 0.8}});
        scene.volumes[0].transferFunction =
            TransferFunction::fromExtinction({{-30, extinction}, {30, extinction}}, {{0, {0.2, 0.3, 0.4}}});
        scene.camera = Camera{.projection = Projection::parallel,
                              .position = {20, 20, 300},
                              .focalPoint = {20, 20, 20},
                              .viewUp = {0, 1, 0},
                              .parallelScale = 4};
        scene.imageSize = {8, 8};
        scene.shading.ambient = 0.9, scene.shading.diffuse = 0.1, scene.shading.specular = 0;
        scene.quality.terminationTransmittance = 0;
        scene.lighting.surfaceOcclusion = SurfaceOcclusion{.rays = 16, .radiusMm = 10, .filter = false};
        Scene plain = scene;
        plain.lighting.surfaceOcclusion.reset();
        for (const EngineKind engine :
             {EngineKind::native, EngineKind::mirror, EngineKind::gpu, EngineKind::reference}) {
            const auto drawn = [&](const Scene& s) {
                Budgets budgets;
                const StoreReader store(stored.folder / "v.zarr", budgets.ram);
                RenderOptions options;
                options.engine = engine;
                options.device = {"software"};
                options.levels = LevelChoice::oneForAll;
                return renderScene(s, store, budgets.ram, budgets.gpu, options).image;
            };
            const Image with = drawn(scene), without = drawn(plain);
            const double depth = 10 * extinction, open = -std::expm1(-depth) / depth;
            for (std::size_t i = 0; i < 64; ++i)
                for (int c = 0; c < 3; ++c) {
                    const double lost = std::exp(-20 * extinction) * 0.8 * (0.5 + 0.1 * c) * 0.9 * (1 - open);
                    EXPECT_NEAR(without.pixels[i][c] - with.pixels[i][c], lost,
                                engine == EngineKind::reference ? 1e-6 + 1e-5 * lost : 1e-6 + 4e-3 * lost)
                        << name(engine);
                }
        }
    }
}

/// Places that a picture sees, against 4096 directions that are spread by other means: the error falls at
/// least as the root of the number.
TEST(SurfaceLight, ErrorFallsWithDirections) {
    Scene scene = occludedScene(0, {20, 20});
    Prepared prepared("torso", scene);
    Planner& p = prepared.p;
    const auto hits = mirrorHits<float>(mirrorInput(p, true), rayCount(p.view.imageSize),
                                        frameRays(cast<float>(p.view.frame)), 0);
    const ReferenceInput input = referenceInput(prepared, scene);
    const ReferenceSurfaces reference(input);
    const MirrorTracer tracer(p, SurfaceLight::kSegmentVoxels);
    const glm::dmat3 toVoxels = glm::inverse(glm::dmat3(p.info().patientFromVoxel));
    const auto spread = sphereDirections(512 * 4 * 4);
    std::vector<int> numbers = {4, 8, 16, 32, 64, 128, 256};
    std::vector<double> squares(numbers.size(), 0);
    int places = 0;
    for (std::size_t i = 0; i < hits.size(); i += 3) {
        const SurfaceHit& hit = hits[i];
        if (hit.surface == 0)
            continue;
        const glm::dvec3 n(hit.normal), above = toVoxels * n;
        const glm::dvec3 from = glm::dvec3(hit.position) +
                                above / std::max({std::abs(above.x), std::abs(above.y), std::abs(above.z)});
        std::vector<LightWay> ways;
        std::vector<double> weights;
        for (const SphereDirection& d : spread) {
            const double cosine = glm::dot(d.towards, n);
            if (cosine <= 0)
                continue;
            const glm::dvec3 v = toVoxels * d.towards;
            RayLine<double> line{from, v / glm::length(v), 0, 1 / glm::length(v)};
            double t0 = 0, t1 = 0;
            const bool inside = clipToBox(line, glm::dvec3(p.info().extentVoxels), t0, t1);
            ways.push_back(
                {from, line.direction, inside ? std::min(t1, 16 / line.mmPerVoxel) : 0.0, line.mmPerVoxel});
            weights.push_back(d.part * cosine);
        }
        const auto taken = traced(reference, ways);
        double open = 0, all = 0;
        for (std::size_t w = 0; w < ways.size(); ++w) {
            open += weights[w] *
                    (1 - static_cast<double>(taken[w].taken) + static_cast<double>(taken[w].mm) / 16);
            all += weights[w];
        }
        open /= all;
        ++places;
        for (std::size_t k = 0; k < numbers.size(); ++k) {
            p.view.lighting.surfaceOcclusion->rays = numbers[k];
            const double found = static_cast<double>(SurfaceLight(p, 0).openAt(
                hit, {static_cast<float>(i % 20) + 0.5f, static_cast<float>(i / 20) + 0.5f}, tracer));
            squares[k] += (found - open) * (found - open);
        }
    }
    ASSERT_GT(places, 40);
    std::vector<double> rms;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
        rms.push_back(std::sqrt(squares[k] / places));
        tell("%d directions: rms %.4f\n", numbers[k], rms[k]);
        EXPECT_LE(rms[k], 1.1 * rms[0] * std::sqrt(4.0 / numbers[k])) << numbers[k];
    }
    EXPECT_LT(rms[0], 0.12);
}

RenderResult rendered(const Scene& scene, EngineKind engine, int threads = 0) {
    Budgets budgets;
    const StoreReader store(storePath("torso"), budgets.ram);
    RenderOptions options;
    options.engine = engine;
    options.threads = threads;
    options.device = {"software"};
    options.levels = LevelChoice::oneForAll;
    return renderScene(scene, store, budgets.ram, budgets.gpu, options);
}

/// Unfiltered, one ray a pixel: what a surface loses of its ambient light is what its place says.
TEST(SurfaceLight, TakesFromTheAmbientLightAlone) {
    for (const int camera : {0, 1}) {
        Scene scene = occludedScene(camera, {24, 24}, {.rays = 16, .radiusMm = 10, .filter = false});
        Scene plain = scene;
        plain.lighting.surfaceOcclusion.reset();
        const Image with = rendered(scene, EngineKind::native).image,
                    without = rendered(plain, EngineKind::native).image;
        Prepared prepared("torso", scene);
        Planner& p = prepared.p;
        const auto hits = mirrorHits<float>(mirrorInput(p, true), rayCount(p.view.imageSize),
                                            frameRays(cast<float>(p.view.frame)), 0);
        const MirrorTracer tracer(p, SurfaceLight::kSegmentVoxels);
        const SurfaceLight light(p, 1);
        double darkest = 0;
        for (std::size_t i = 0; i < hits.size(); ++i) {
            const glm::vec2 place(static_cast<float>(i % 24) + 0.5f, static_cast<float>(i / 24) + 0.5f);
            const float open = light.openAt(hits[i], place, tracer);
            glm::vec3 colour(0);
            float opacity = 0;
            if (hits[i].surface != 0) {
                const Isosurface& s = scene.surfaces[static_cast<std::size_t>(hits[i].surface) - 1];
                colour = glm::vec3(s.colour), opacity = static_cast<float>(s.opacity);
            }
            EXPECT_EQ(with.pixels[i].a, without.pixels[i].a);
            for (int c = 0; c < 3; ++c) {
                const float lost = 0.8f * opacity * colour[c] * (1 - open);
                ASSERT_NEAR(with.pixels[i][c], without.pixels[i][c] - lost, 1e-5) << i;
                darkest = std::max(darkest, static_cast<double>(lost));
            }
        }
        EXPECT_GT(darkest, 0.05);
    }
}

/// Every engine; the reference's steps are others in a volume.
TEST(SurfaceLight, EnginesAgreeInAVolume) {
    for (const bool graded : {false, true}) {
        Scene scene = inVolume(occludedScene(0, {32, 32}, {.rays = 8, .filter = false}), graded);
        scene.quality.stepVoxels = 0.25;
        Scene plain = scene;
        plain.lighting.surfaceOcclusion.reset();
        const auto lost = [&](EngineKind engine) {
            Image with = rendered(scene, engine).image;
            const Image without = rendered(plain, engine).image;
            for (std::size_t i = 0; i < with.pixels.size(); ++i)
                with.pixels[i] = without.pixels[i] - with.pixels[i];
            return with;
        };
        const Image native = lost(EngineKind::native);
        EXPECT_EQ(differing(lost(EngineKind::mirror), native), 0u);
        double most = 0;
        for (const glm::vec4& pixel : native.pixels)
            most = std::max(most, double{pixel.r});
        EXPECT_GT(most, 0.05);
        EXPECT_LT(compare(lost(EngineKind::gpu), native).rms, 1e-3);
        EXPECT_LT(compare(lost(EngineKind::reference), native).rms, 0.1 * most);
    }
}

/// Every engine, the reference among them, whose rays, places and ways are its own.
TEST(SurfaceLight, EnginesAgree) {
    for (const bool filter : {false, true}) {
        const Scene scene = occludedScene(0, {32, 32}, {.rays = 8, .filter = filter});
        const Image native = rendered(scene, EngineKind::native).image,
                    mirror = rendered(scene, EngineKind::mirror).image;
        EXPECT_EQ(differing(native, mirror), 0u);
        for (const EngineKind engine : {EngineKind::gpu, EngineKind::reference}) {
            const Image other = rendered(scene, engine).image;
            std::size_t off = 0, seen = 0;
            for (std::size_t i = 0; i < native.pixels.size(); ++i) {
                float most = 0;
                for (int c = 0; c < 4; ++c)
                    most = std::max(most, std::abs(native.pixels[i][c] - other.pixels[i][c]));
                off += most > 1e-4f;
                seen += native.pixels[i].a > 0;
            }
            EXPECT_GT(seen, 200u);
            EXPECT_LE(off, seen / 50) << name(engine) << (filter ? ", filtered" : "");
        }
    }
}

TEST(SurfaceLight, IsTheSameWhateverThreadsAndSamples) {
    for (const int samples : {1, 8, PixelSampling::kAutomatic}) {
        Scene scene = occludedScene(0, {32, 32}, {.rays = 8});
        scene.quality.pixels.samples = samples;
        const Image one = rendered(scene, EngineKind::native, 1).image;
        EXPECT_EQ(differing(rendered(scene, EngineKind::native, 3).image, one), 0u) << samples;
        EXPECT_EQ(differing(rendered(scene, EngineKind::mirror, 2).image, one), 0u) << samples;
        Scene other = scene;
        other.quality.pixels.seed = 5;
        EXPECT_GT(differing(rendered(other, EngineKind::native).image, one), 0u) << "another seed";
        Scene plain = scene;
        plain.lighting.surfaceOcclusion.reset();
        const Image bare = rendered(plain, EngineKind::native).image;
        double darker = 0, sum = 0;
        for (std::size_t i = 0; i < one.pixels.size(); ++i) {
            darker += static_cast<double>(bare.pixels[i].g - one.pixels[i].g);
            sum += static_cast<double>(bare.pixels[i].g);
            ASSERT_EQ(one.pixels[i].a, bare.pixels[i].a);
        }
        EXPECT_GT(darker / sum, 0.01) << samples;
        EXPECT_LT(darker / sum, 0.6) << samples;
    }
}

/// The error of directions falls, and the two sides of an edge stay as they are.
TEST(SurfaceLight, TheFilterSmoothsAndKeepsEdges) {
    const auto errors = [](bool filter, double& near) {
        Scene scene = occludedScene(0, {96, 96}, {.rays = 8, .radiusMm = 12, .filter = filter});
        std::get<Camera>(scene.camera).viewAngle = 2; // pixels are finer than what shares
        Scene fine = scene;
        fine.lighting.surfaceOcclusion = SurfaceOcclusion{256, 12, false};
        const Image with = rendered(scene, EngineKind::native).image,
                    truth = rendered(fine, EngineKind::native).image;
        double sum = 0, seen = 0;
        near = 0;
        for (std::size_t i = 0; i < with.pixels.size(); ++i) {
            const double d = static_cast<double>(with.pixels[i].g - truth.pixels[i].g);
            sum += d * d;
            near = std::max(near, std::abs(d));
            seen += with.pixels[i].a > 0;
        }
        return std::sqrt(sum / seen);
    };
    double nearWith = 0, nearWithout = 0;
    const double with = errors(true, nearWith), without = errors(false, nearWithout);
    tell("unfiltered rms %.4f, most %.4f; filtered %.4f, %.4f\n", without, nearWithout, with, nearWith);
    EXPECT_LT(with, 0.8 * without);
    EXPECT_LT(nearWith, nearWithout);
}

/// A corner that is darker towards its wall, with the wall at the picture's top, bottom, left and right:
/// means over lines along the wall do not depend on that.
TEST(SurfaceLight, TheFilterHasNoSide) {
    const Stored stored(cornerField(), glm::ivec3(40), true);
    const auto means = [&](const glm::dvec3& up, bool rows, bool backwards) {
        Scene scene = corner(stored, {.rays = 64, .radiusMm = 12});
        scene.imageSize = {64, 64};
        Camera camera;
        camera.projection = Projection::parallel;
        camera.focalPoint = {17, 20, 10};
        camera.position = {17, 20, 60};
        camera.viewUp = up;
        camera.parallelScale = 5;
        scene.camera = camera;
        const Image image = rendered(scene, EngineKind::native).image;
        std::vector<double> lines(64);
        for (std::size_t n = 0; n < image.pixels.size(); ++n) {
            const std::size_t line = rows ? n / 64 : n % 64;
            lines[backwards ? 63 - line : line] += static_cast<double>(image.pixels[n].g) / 64;
        }
        return lines;
    };
    const std::vector<double> top = means({-1, 0, 0}, true, false), bottom = means({1, 0, 0}, true, true),
                              left = means({0, 1, 0}, false, false), right = means({0, -1, 0}, false, true);
    EXPECT_GT(std::abs(top[60] - top[3]), 0.05) << "nothing is tested";
    double sums[3] = {};
    for (std::size_t n = 3; n < 61; ++n) {
        sums[0] += (bottom[n] - top[n]) / 58;
        sums[1] += (left[n] - top[n]) / 58;
        sums[2] += (right[n] - top[n]) / 58;
    }
    for (const double sum : sums)
        EXPECT_NEAR(sum, 0, 4e-4);
}

/// Places that share are near in mm. A volume of larger voxels, seen from as much further away, gives the
/// same picture.
TEST(SurfaceLight, TheFilterKnowsNoVoxels) {
    const auto pictureAt = [](double mmPerVoxel) {
        const ScratchFolder folder;
        VolumeInfo info;
        info.type = ValueType::f32;
        info.extentVoxels = glm::ivec3(40);
        info.patientFromVoxel =
            patientFromVoxelOf({0, 0, 0}, {mmPerVoxel, 0, 0}, {0, mmPerVoxel, 0}, {0, 0, mmPerVoxel});
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        FormulaSource source(info, cornerField());
        importToStore(source, folder / "v.zarr", ram, {});
        Scene scene = sceneOn(info, "bone-1", 0, {48, 48});
        scene.volumes[0].path = folder / "v.zarr";
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction({}, {});
        scene.surfaces = {{0, glm::dvec3(1), 1}};
        scene.lighting.surfaceOcclusion = SurfaceOcclusion{8, 12 * mmPerVoxel, true};
        scene.shading.ambient = 0.8, scene.shading.diffuse = 0.2, scene.shading.specular = 0;
        Camera camera;
        camera.focalPoint = mmPerVoxel * glm::dvec3(14, 20, 12);
        camera.position = mmPerVoxel * glm::dvec3(90, 35, 100);
        camera.viewUp = {0, 1, 0};
        camera.viewAngle = 8; // pixels are finer than what shares
        scene.camera = camera;
        MemoryBudget gpu("GPU", "--gpu", std::size_t{256} << 20);
        RenderOptions options;
        options.engine = EngineKind::native;
        const StoreReader store(folder / "v.zarr", ram);
        return renderScene(scene, store, ram, gpu, options).image;
    };
    const Image one = pictureAt(1);
    double darkest = 1;
    for (const glm::vec4& pixel : one.pixels)
        darkest = pixel.a > 0 ? std::min(darkest, static_cast<double>(pixel.g)) : darkest;
    EXPECT_LT(darkest, 0.9);
    for (const double mmPerVoxel : {0.25, 5.0}) {
        const Image other = pictureAt(mmPerVoxel);
        double most = 0;
        for (std::size_t i = 0; i < one.pixels.size(); ++i)
            most = std::max(most, static_cast<double>(std::abs(one.pixels[i].g - other.pixels[i].g)));
        EXPECT_LT(most, 2e-3) << mmPerVoxel;
    }
}

/// It is the occlusion of what surfaces show, in place of that of voxels; shadows stay.
TEST(SurfaceLight, TakesThePlaceOfTheVoxels) {
    Scene scene = occludedScene(0, {24, 24}, {.rays = 8});
    Scene both = scene;
    both.lighting.occlusion = Occlusion{};
    const RenderResult one = rendered(scene, EngineKind::native), two = rendered(both, EngineKind::native);
    EXPECT_EQ(differing(one.image, two.image), 0u);
    EXPECT_FALSE(two.light);
    both.lighting.lights = scene.lighting.lights = {keyLight()};
    const RenderResult shaded = rendered(both, EngineKind::native);
    ASSERT_TRUE(shaded.light);
    EXPECT_EQ(shaded.light->channels, 1);
    EXPECT_EQ(differing(rendered(scene, EngineKind::native).image, shaded.image), 0u);
}

/// Surfaces beside a picture attenuate light too.
TEST(SurfaceLight, BricksBesideThePictureStay) {
    Scene scene = occludedScene(0, {64, 64}, {.rays = 4});
    std::get<Camera>(scene.camera).viewAngle = 2;
    EXPECT_EQ(unseenBricks(scene), 0u);
    scene.lighting.surfaceOcclusion.reset();
    EXPECT_GT(unseenBricks(scene), 0u);
}

TEST(SurfaceLight, RefusalsHelp) {
    const auto refused = [](const Scene& scene) -> std::string {
        try {
            rendered(scene, EngineKind::native);
        } catch (const InputError& e) {
            return e.what();
        }
        return "nothing was refused";
    };
    const Scene scene = occludedScene(0);
    Scene volume = scene, unlit = scene, none = scene;
    volume.volumes[0].transferFunction = std::string("bone-1");
    EXPECT_EQ(refused(volume), "nothing was refused");
    volume.mode = Mode::isosurface;
    EXPECT_EQ(refused(volume), "nothing was refused");
    unlit.shading.on = false;
    EXPECT_THAT(refused(unlit), HasSubstr("lighting.surfaceOcclusion: occlusion is light"));
    none.surfaces.clear();
    EXPECT_THAT(refused(none), HasSubstr("lighting.surfaceOcclusion: expected an isosurface"));
    none.mode = Mode::maximum; // shows no light
    EXPECT_EQ(refused(none), "nothing was refused");
}

TEST(SurfaceLight, CostsNothingWhereItIsNotAskedFor) {
    Scene scene = occludedScene(0, {48, 48}, {.rays = 4});
    Scene plain = scene;
    plain.lighting.surfaceOcclusion.reset();
    const auto drawn = [](const Scene& s, std::size_t& ram, std::size_t& gpu) {
        Budgets budgets;
        const StoreReader store(storePath("torso"), budgets.ram);
        RenderOptions options;
        options.engine = EngineKind::native;
        RenderResult result = renderScene(s, store, budgets.ram, budgets.gpu, options);
        ram = budgets.ram.peakBytes(), gpu = budgets.gpu.peakBytes();
        return result;
    };
    std::size_t ram[2], gpu[2];
    const RenderResult with = drawn(scene, ram[0], gpu[0]), without = drawn(plain, ram[1], gpu[1]);
    EXPECT_TRUE(with.surfaceLight && with.surfaceLight->places > 0);
    EXPECT_FALSE(without.surfaceLight);
    EXPECT_EQ(gpu[0] - gpu[1], 48u * 48u * sizeof(SurfaceHit));
    // Of pixels where nothing is met, no bit changes.
    for (std::size_t i = 0; i < with.image.pixels.size(); ++i)
        EXPECT_TRUE(without.image.pixels[i].a != 0 || with.image.pixels[i] == glm::vec4(0));
}

} // namespace
} // namespace tessera::test

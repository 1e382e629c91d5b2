// tests/render/contract/cuts_test.cpp: boxes, planes and scissors cut rays at the right places
// (docs/sampling.md, "Cuts"). They are compared with membership written out here and with the reference, and
// every engine and division of the work with every other.
#include "render/backends/reference/reference.h"
#include "render/picture/render_scene.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/value_scenes.h"

#include <cmath>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kSize(37, 41); // no packet's edges divide it

/// A concave outline with a hole where it crosses itself.
std::vector<glm::dvec2> star(double radius) {
    std::vector<glm::dvec2> points;
    for (int n = 0; n < 5; ++n) {
        const double a = 4 * std::acos(-1.0) * n / 5 + 0.3;
        points.emplace_back(0.5 + radius * std::cos(a), 0.5 + radius * std::sin(a));
    }
    return points;
}

Cuts cutsNumber(int number, const VolumeInfo& info) {
    const glm::dvec3 middle = middleOf(info), size = info.spacingMm() * glm::dvec3(info.extentVoxels);
    Cuts cuts;
    const auto box = [&](double low, double high, Keep keep) {
        cuts.boxes.push_back({middle + low * size, middle + high * size, CropBox::Space::patient, keep});
    };
    const auto plane = [&](const glm::dvec3& normal, double away, Keep keep = Keep::inside) {
        cuts.planes.push_back({middle - away * glm::length(size) * glm::normalize(normal), normal, keep});
    };
    const auto scissors = [&](View view, Projection projection, double radius, Keep keep) {
        cuts.scissors.push_back({fitCamera(info, view, projection, {150, 100}), 1.5, star(radius), keep});
    };
    switch (number) {
    case 0:
        box(-0.3, 0.22, Keep::inside);
        break;
    case 1:
        box(-0.21, 0.33, Keep::outside);
        break;
    case 2:
        plane({0.4, 1, 0.2}, -0.02);
        plane({-1, 0.3, 0.1}, 0.15, Keep::outside);
        break;
    case 3:
        scissors(View::anterior, Projection::perspective, 0.4, Keep::inside);
        break;
    case 4:
        scissors(View::left, Projection::parallel, 0.35, Keep::outside);
        break;
    case 5: // more planes than there are slabs
        for (int n = 0; n < 11; ++n)
            plane({std::cos(0.6 * n), std::sin(0.6 * n), 0.3 * std::cos(1.1 * n)}, 0.17);
        break;
    case 6:
        box(-0.12, 0.1, Keep::outside);
        box(-0.4, 0.4, Keep::inside);
        plane({0, 1, 0.3}, 0.2);
        scissors(View::superior, Projection::parallel, 0.3, Keep::outside);
        scissors(View::posterior, Projection::perspective, 0.45, Keep::inside);
        break;
    default:
        cuts.boxes.push_back({{5.25, 9.5, 3},
                              {glm::dvec3(info.extentVoxels) - glm::dvec3(7.5, 3, 4.75)},
                              CropBox::Space::voxels,
                              Keep::inside});
    }
    return cuts;
}
constexpr int kCutsCount = 8;

bool keeps(Keep keep, bool inside) {
    return inside == (keep == Keep::inside);
}
/// True if a place is drawn, by the definition of cuts.
bool isKept(const Cuts& cuts, const glm::dvec3& mm, const glm::dvec3& voxel) {
    for (const CropBox& b : cuts.boxes) {
        const glm::dvec3 p = b.space == CropBox::Space::voxels ? voxel : mm;
        if (!keeps(b.keep, glm::all(glm::greaterThan(p, b.low)) && glm::all(glm::lessThan(p, b.high))))
            return false;
    }
    for (const CutPlane& p : cuts.planes)
        if (!keeps(p.keep, glm::dot(mm - p.point, p.normal) > 0))
            return false;
    for (const Scissors& s : cuts.scissors) {
        const Camera& c = s.camera;
        const glm::dvec3 forward = glm::normalize(c.focalPoint - c.position);
        const glm::dvec3 right = glm::normalize(glm::cross(forward, c.viewUp)),
                         up = glm::cross(right, forward);
        const double depth = glm::dot(mm - c.position, forward);
        const double half = c.projection == Projection::parallel
                                ? c.parallelScale
                                : depth * std::tan(glm::radians(c.viewAngle) / 2);
        const glm::dvec2 at(0.5 + 0.5 * glm::dot(mm - c.position, right) / (half * s.aspect),
                            0.5 - 0.5 * glm::dot(mm - c.position, up) / half);
        // Even-odd, by the sum of signed crossings of a ray to the right.
        int crossings = 0;
        for (std::size_t n = 0; n < s.outline.size(); ++n) {
            const glm::dvec2 a = s.outline[n], b = s.outline[(n + 1) % s.outline.size()];
            const bool rises = a.y <= at.y && b.y > at.y, falls = b.y <= at.y && a.y > at.y;
            if (rises || falls)
                crossings += a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x) > at.x ? 1 : 0;
        }
        if (!keeps(s.keep, crossings % 2 == 1 && (c.projection == Projection::parallel || depth > 0)))
            return false;
    }
    return true;
}

Scene cutScene(const std::string& store, const char* preset, int cuts, int camera,
               const glm::ivec2& size = kSize) {
    const VolumeInfo info = infoOf(store);
    Scene scene = sceneOn(info, preset, camera, size);
    scene.cuts = cutsNumber(cuts, info);
    return scene;
}

CutRays cutsOf(const FramePlan& p) {
    return cutRays(p.view.frame, {}, 0);
}
Image mirrorCut(const Prepared& prepared, std::span<const SegmentedRay<float>> rays = {}) {
    const FramePlan& p = prepared.p;
    Image image(p.view.imageSize);
    Work work;
    MirrorInput input = mirrorInput(p, p.view.quality.skipping);
    std::optional<CutRays> cuts;
    if (p.view.frame.cuts)
        input.cuts = &cuts.emplace(cutsOf(p));
    input.segmentVoxels = p.view.quality.stepVoxels;
    const auto own = frameRays(cast<float>(p.view.frame));
    image.pixels = mirrorRays<float>(
        input, image.pixels.size(), [&](std::size_t i) { return rays.empty() ? own(i) : rays[i]; }, 0, work);
    return image;
}

class CutRay : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Cuts, CutRay, testing::Range(0, kCutsCount));

TEST_P(CutRay, ItsLengthIsThatOfWhatIsKept) {
    int cut = 0;
    for (const int camera : {0, 1, 2}) {
        Scene scene = cutScene("sphere", "bone-1", GetParam(), camera, {15, 15});
        scene.shading.on = false;
        constexpr double kPerMm = 0.01;
        scene.volumes.front().transferFunction = fog(kPerMm);
        Prepared prepared("sphere", scene);
        const FramePlan& p = prepared.p;
        const VolumeInfo& info = p.info();
        ReferenceInput reference;
        reference.cache = p.layer().cache.get();
        reference.info = &info;
        reference.function = &p.layer().function;
        reference.shading = scene.shading;
        reference.slabs = p.view.part.slabs;
        reference.cuts = p.view.part.cuts.get();
        const auto truth = renderReference(reference, referenceRays(p.view.camera, info, {15, 15}), 0);
        const Image mirror = mirrorCut(prepared);
        const RayPlane plane = rayPlane(std::get<Camera>(scene.camera), info, {15, 15});
        const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
        const double far = 2 * glm::length(info.spacingMm() * glm::dvec3(info.extentVoxels)),
                     step = far / 40000;
        for (int n = 0; n < 225; ++n) {
            const PatientRay ray = pixelRay(plane, glm::dvec2(n % 15, n / 15) + 0.5, {15, 15});
            double kept = 0, all = 0;
            for (double t = std::max(ray.minT, -far); t < far; t += step) {
                const glm::dvec3 mm = ray.base + t * ray.direction;
                const glm::dvec3 p3(voxelFromPatient * glm::dvec4(mm, 1));
                if (glm::any(glm::lessThan(p3, glm::dvec3(0))) ||
                    glm::any(glm::greaterThan(p3, glm::dvec3(info.extentVoxels))))
                    continue;
                all += step;
                kept += isKept(scene.cuts, mm, p3) ? step : 0;
            }
            const double expected = -std::expm1(-kPerMm * kept), tolerance = 8 * kPerMm * step;
            EXPECT_NEAR(truth[static_cast<std::size_t>(n)].a, expected, tolerance) << camera << ", " << n;
            EXPECT_NEAR(double{mirror.pixels[static_cast<std::size_t>(n)].a},
                        truth[static_cast<std::size_t>(n)].a, 1e-5)
                << camera << ", " << n;
            cut += kept < all - 4 * step && kept > 4 * step;
        }
    }
    EXPECT_GT(cut, 25) << "few rays are cut";
}

struct CutCase {
    const char* store;
    const char* preset;
    int cuts, camera;
    Integrator integrator = Integrator::midpoint;
    std::optional<double> isovalue = {};
    Mode mode = Mode::composite;
};
std::ostream& operator<<(std::ostream& out, const CutCase& c) {
    return out << c.store << ", " << c.preset << ", cuts " << c.cuts << ", camera " << c.camera << ", "
               << integratorNames()[static_cast<std::size_t>(c.integrator)] << (c.isovalue ? ", surface" : "")
               << ", " << modeNames()[static_cast<std::size_t>(c.mode)];
}

class CutPicture : public testing::TestWithParam<CutCase> {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists(storePath(GetParam().store)))
            GTEST_SKIP() << GetParam().store << " is absent: the real scans are not on this machine";
    }
    Scene scene(const glm::ivec2& size = kSize) const {
        const CutCase& c = GetParam();
        Scene s = cutScene(c.store, c.preset, c.cuts, c.camera, size);
        s.quality.integrator = c.integrator;
        s.quality.terminationTransmittance = 1.0 / 510;
        if (c.isovalue)
            s.surfaces = {{*c.isovalue, {0.9, 0.8, 0.6}, 0.6}};
        s.mode = c.mode;
        s.window = GreyWindow{20, 900};
        return s;
    }
};
INSTANTIATE_TEST_SUITE_P(
    Scenes, CutPicture,
    testing::Values(CutCase{"torso", "soft-tissue", 0, 0}, CutCase{"torso", "soft-tissue", 1, 1},
                    CutCase{"torso", "bone-1", 2, 0},
                    CutCase{"torso", "soft-tissue", 3, 0, Integrator::linear},
                    CutCase{"torso", "soft-tissue", 4, 2, Integrator::preintegrated},
                    CutCase{"torso", "bone-1", 5, 0, Integrator::preintegrated2d},
                    CutCase{"torso", "soft-tissue", 6, 1},
                    CutCase{"torso", "soft-tissue", 6, 0, Integrator::midpoint, 300.0},
                    CutCase{"torso", "bone-1", 4, 1, Integrator::linear, 0.0},
                    CutCase{"torso", "bone-1", 6, 2, Integrator::midpoint, 200.0, Mode::isosurface},
                    CutCase{"torso", "bone-1", 6, 0, Integrator::midpoint, {}, Mode::maximum},
                    CutCase{"torso", "bone-1", 1, 1, Integrator::midpoint, {}, Mode::minimum},
                    CutCase{"torso", "bone-1", 4, 0, Integrator::midpoint, {}, Mode::average},
                    CutCase{"torso", "bone-1", 6, 0, Integrator::midpoint, {}, Mode::slice},
                    CutCase{"head", "skin-1", 1, 0}, CutCase{"abdomen", "soft-tissue", 6, 1}));

TEST_P(CutPicture, NativeHasTheMirrorsBits) {
    for (const bool mixed : {false, true}) {
        Prepared prepared(GetParam().store, scene());
        if (mixed)
            prepared.p.setSelection(randomShownLevels(prepared.p.layer().selection, 7));
        const Image mirror = mirrorCut(prepared);
        EXPECT_FALSE(isBlank(mirror));
        for (const native::PacketTarget* target : nativeTargets()) {
            NativeChoices choices;
            choices.target = target;
            EXPECT_EQ(differing(nativePicture(prepared, choices).image, mirror), 0u) << target->name << mixed;
            choices.slicing.fixedIterations = 3;
            choices.shreds = true;
            EXPECT_EQ(differing(nativePicture(prepared, choices).image, mirror), 0u) << target->name << mixed;
        }
        prepared.p.view.quality.skipping = false;
        EXPECT_EQ(differing(mirrorCut(prepared), mirror), 0u) << "skipping changed the picture";
    }
}

TEST_P(CutPicture, LeavingOutBricksChangesNoBit) {
    Prepared some(GetParam().store, scene()), all(GetParam().store, scene(), false);
    EXPECT_EQ(differing(mirrorCut(some), mirrorCut(all)), 0u);
}

TEST_P(CutPicture, MarchEqualsTheMirrorOnItsOwnRays) {
    const GlContext context({"software"});
    Prepared prepared(GetParam().store, scene());
    Planner& p = prepared.p;
    const std::uint32_t features = marchFeatures(p, false);
    const Image march = marchOn(prepared, features).image;
    EXPECT_FALSE(isBlank(march));
    const auto rays = gpuRays(raysOf(p), prepared.budgets.gpu);
    const Image mirror = mirrorCut(prepared, rays);
    double largest = 0;
    for (std::size_t i = 0; i < march.pixels.size(); ++i)
        for (int c = 0; c < 4; ++c)
            largest = std::max(largest, double{std::abs(march.pixels[i][c] - mirror.pixels[i][c])});
    EXPECT_LE(largest, 2e-5);
    Slicing shreds;
    shreds.fixedTile = 24;
    shreds.fixedIterations = 7;
    EXPECT_TRUE(bitEqual(marchOn(prepared, features, shreds).image, march));
}

TEST_P(CutPicture, PassesChangeNoBit) {
    const auto draw = [&](EngineKind engine, std::size_t gpuBytes) {
        Scene scene = this->scene({48, 40});
        scene.quality.stepVoxels = 0.5;
        scene.quality.maxError = 0;
        MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20), gpu("GPU memory", "--gpu-memory", gpuBytes);
        const StoreReader reader(storePath(GetParam().store), ram);
        RenderOptions options;
        options.engine = engine;
        options.device.text = "software";
        return renderScene(scene, reader, ram, gpu, options);
    };
    const RenderResult whole = draw(EngineKind::native, std::size_t{1} << 30);
    const RenderResult parts = draw(EngineKind::native, std::size_t{9} << 20);
    EXPECT_EQ(differing(whole.image, parts.image), 0u);
    EXPECT_EQ(differing(draw(EngineKind::mirror, std::size_t{1} << 30).image, whole.image), 0u);
}

// A camera in the middle of the volume: its pyramid is in front of it alone.
TEST(CutScissors, NothingBehindTheEyeIsInside) {
    const VolumeInfo info = infoOf("sphere");
    Scissors scissors;
    scissors.camera.position = middleOf(info);
    scissors.camera.focalPoint = scissors.camera.position + glm::dvec3(0, 10, 0);
    scissors.camera.viewAngle = 60;
    scissors.outline = {{0.1, 0.1}, {0.9, 0.1}, {0.9, 0.9}, {0.1, 0.9}};
    RayCuts cuts;
    cuts.add(scissors, info);
    const glm::dvec3 eye = 0.5 * glm::dvec3(info.extentVoxels);
    std::vector<RayCuts::Part> parts;
    cuts.parts(eye + glm::dvec3(0.3, -20, 0.2), {0, 1, 0}, 0, 40, parts); // through the eye's plane, ahead
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_GT(parts[0].from, 20);
    EXPECT_EQ(parts[0].to, 40);
    cuts.parts(eye + glm::dvec3(0.3, -1, 0.2), {0, -1, 0}, 0, 15, parts);
    EXPECT_TRUE(parts.empty());
}

TEST(CutNothing, RaysWithoutCutsAreAsTheyWere) {
    const VolumeInfo info = infoOf("torso");
    Scene scene = sceneOn(info, "bone-1", 0, kSize);
    Prepared plain("torso", scene);
    EXPECT_FALSE(plain.p.view.part.any());
    EXPECT_EQ(plain.p.view.frame.slabCount, 0);
    EXPECT_EQ(plain.p.view.frame.cuts, nullptr);
    EXPECT_EQ(marchFeatures(plain.p, false) & (kFeatureSlabs | kFeatureIntervals | kFeatureValues), 0u);
    const glm::dvec3 far(1e5);
    scene.cuts.boxes.push_back({-far, far});
    Prepared cut("torso", scene);
    EXPECT_EQ(differing(mirrorCut(cut), mirrorPicture(plain)), 0u)
        << "a cut that cuts nothing changed the picture";
}

TEST(CutNothing, WhatIsNoCutIsRefused) {
    const VolumeInfo info = infoOf("torso");
    const auto refused = [&](const auto& add) {
        Scene scene = sceneOn(info, "bone-1", 0, kSize);
        add(scene.cuts);
        EXPECT_THROW(drawnPart(scene, info), InputError);
    };
    refused([](Cuts& c) { c.boxes.push_back({{0, 0, 0}, {1, 0, 1}}); });
    refused([](Cuts& c) { c.boxes.push_back({{0, 0, 0}, {1, 1, NAN}}); });
    refused([](Cuts& c) { c.planes.push_back({{0, 0, 0}, {0, 0, 0}}); });
    refused([](Cuts& c) { c.scissors.push_back({Camera(), 1, {{0, 0}, {1, 1}}}); });
    refused([](Cuts& c) { c.scissors.push_back({Camera(), 0, star(0.3)}); });
}

} // namespace
} // namespace tessera

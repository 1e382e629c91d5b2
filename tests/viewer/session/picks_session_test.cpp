// tests/viewer/session/picks_session_test.cpp: the place under a point of the picture is where a walk along
// the point's ray, in small steps and by interpolation written out, finds what the picture shows there.
#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "tests/support/formula_source.h"
#include "tests/support/looker.h"
#include "viewer/session/view_geometry.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>
#include <variant>
#include <vector>

namespace tessera::test {
namespace {

double formula(const glm::dvec3& p) {
    return 300 * std::sin(0.11 * p.x + 0.3) * std::cos(0.09 * p.y) + 250 * std::sin(0.07 * p.z) + 3 * p.x;
}

VolumeInfo sheared() {
    VolumeInfo info;
    info.extentVoxels = {45, 37, 70};
    info.type = ValueType::f32;
    info.rescaleSlope = 0.5;
    info.rescaleIntercept = -100;
    info.patientFromVoxel = glm::dmat4(1.4, 0, 0.2, 0, 0.1, 1.1, 0, 0, 0, 0.3, 0.9, 0, -50, 20, 300, 1);
    return info;
}

class Picks : public ::testing::Test {
  protected:
    Picks() {
        FormulaSource source(info_, formula);
        MemoryBudget ram("RAM", "--ram", kRamBytes);
        importToStore(source, folder_ / "v.zarr", ram, {});
        scene_ = looker_.opened(folder_ / "v.zarr");
        Camera camera;
        camera.position = {160, -150, 420};
        camera.focalPoint = glm::dvec3(info_.patientFromVoxel * glm::dvec4(22, 18, 35, 1));
        camera.viewUp = {0.1, 0.2, 1};
        camera.viewAngle = 22;
        scene_.camera = camera;
        scene_.volumes[0].transferFunction =
            TransferFunction::fromOpacity({{-1000, 0}, {-900, 0}}, {{0, {1, 1, 1}}}, 1);
    }
    PickedPlace at(const glm::dvec2& place) {
        const std::uint64_t question = looker_.viewing->pick(place);
        EXPECT_TRUE(looker_.comesTo(
            [&] { return looker_.viewing->picked() && looker_.viewing->picked()->number >= question; }));
        return *looker_.viewing->picked();
    }
    /// Voxels along the ray of a place, in steps of 0.05 mm, that are in the volume and drawn.
    std::vector<glm::dvec3> along(const glm::dvec2& place) const {
        const PatientRay ray =
            pixelRay(rayPlane(std::get<Camera>(scene_.camera), info_, kPicture), place, kPicture);
        const glm::dmat4 voxelFromPatient = glm::inverse(info_.patientFromVoxel);
        std::vector<glm::dvec3> voxels;
        for (int n = -6000; n < 6000; ++n) {
            const glm::dvec3 mm = ray.base + 0.05 * n * glm::normalize(ray.direction);
            const glm::dvec3 voxel(voxelFromPatient * glm::dvec4(mm, 1));
            if (glm::clamp(voxel, glm::dvec3(0), glm::dvec3(info_.extentVoxels)) != voxel)
                continue;
            bool drawn = true;
            for (const CutPlane& plane : scene_.cuts.planes)
                drawn = drawn && glm::dot(mm - plane.point, plane.normal) >= 0;
            if (drawn)
                voxels.push_back(voxel);
        }
        return voxels;
    }
    /// The place that a walk finds, at several points of the picture.
    /// @param tolerance  voxels
    void expectFound(const std::function<std::size_t(const std::vector<double>&)>& find, double tolerance) {
        looker_.wholeOf(looker_.viewing->show(scene_, false));
        for (const glm::dvec2& place :
             {glm::dvec2(48, 36), {30.5, 20.25}, {60, 47}, {41, 55}, {66.5, 25}, {2, 3}}) {
            const std::vector<glm::dvec3> voxels = along(place);
            std::vector<double> values;
            for (const glm::dvec3& voxel : voxels)
                values.push_back(trilinearOf(info_, formula, voxel));
            const std::size_t found = values.empty() ? 0 : find(values);
            const PickedPlace picked = at(place);
            ASSERT_EQ(picked.hit, found < values.size()) << place.x << " " << place.y;
            if (!picked.hit)
                continue;
            EXPECT_LT(glm::length(picked.voxel - voxels[found]), tolerance)
                << place.x << " " << place.y << ": " << picked.voxel.z << ", expected " << voxels[found].z;
            EXPECT_NEAR(picked.value, trilinearOf(info_, formula, picked.voxel), 0.01);
            EXPECT_LT(
                glm::length(picked.mm - glm::dvec3(info_.patientFromVoxel * glm::dvec4(picked.voxel, 1))),
                1e-9);
            EXPECT_EQ(picked.level, 0);
            EXPECT_EQ(picked.mesh, "");
        }
    }
    const ScratchFolder folder_;
    const VolumeInfo info_ = sheared();
    Looker looker_{false};
    Scene scene_;
};

// On a plane it is the plane's point, seen at that place, unless a cut takes it away.
TEST_F(Picks, OnASliceAreThePlanesPoint) {
    const glm::dvec3 middle(info_.patientFromVoxel * glm::dvec4(22, 18, 35, 1));
    for (const bool cut : {false, true}) {
        scene_.mode = Mode::slice;
        scene_.slice.orientation = Orientation::oblique;
        scene_.slice.point = middle;
        scene_.slice.normal = glm::normalize(
            glm::normalize(std::get<Camera>(scene_.camera).position - middle) + glm::dvec3(0.3, 0.1, -0.2));
        if (cut)
            scene_.cuts.planes = {{middle, {1, 0.2, 0}}};
        looker_.wholeOf(looker_.viewing->show(scene_, false));
        int hits = 0, misses = 0;
        for (int y = 6; y < kPicture.y; y += 6)
            for (int x = 8; x < kPicture.x; x += 8) {
                const glm::dvec2 place(x + 0.25, y + 0.5);
                const PickedPlace picked = at(place);
                ++(picked.hit ? hits : misses);
                if (!picked.hit)
                    continue;
                EXPECT_NEAR(glm::dot(picked.mm - middle, scene_.slice.normal), 0, 1e-6);
                glm::dvec2 pixel(0);
                ASSERT_TRUE(
                    pictureFromPatient(looker_.viewing->picture()->camera, kPicture, picked.mm, pixel));
                EXPECT_LT(glm::distance(pixel, place), 1e-4) << pixel.x << " " << pixel.y;
                EXPECT_NEAR(picked.value, trilinearOf(info_, formula, picked.voxel), 0.01);
                EXPECT_TRUE(!cut || glm::dot(picked.mm - middle, {1, 0.2, 0}) >= -1e-4);
            }
        EXPECT_GT(hits, cut ? 5 : 12);
        EXPECT_GT(misses, 0);
    }
}

/// All voxels of level 0 are counted; roundings to float may move one to the next bin.
TEST_F(Picks, TheHistogramCountsAllVoxels) {
    const VolumeSeen& seen = *looker_.viewing->volume();
    const std::vector<double>& counts = seen.histogram;
    ASSERT_GE(counts.size(), 64u);
    const double low = seen.values.lowest, high = seen.values.highest;
    std::vector<double> expected(counts.size());
    const auto bins = static_cast<double>(counts.size());
    for (int z = 0; z < info_.extentVoxels.z; ++z)
        for (int y = 0; y < info_.extentVoxels.y; ++y)
            for (int x = 0; x < info_.extentVoxels.x; ++x) {
                const double value = 0.5 * formula({x + 0.5, y + 0.5, z + 0.5}) - 100;
                const double bin = std::floor((value - low) / (high - low) * bins);
                ++expected[static_cast<std::size_t>(glm::clamp(bin, 0.0, bins - 1))];
            }
    for (std::size_t n = 0; n < counts.size(); ++n)
        EXPECT_NEAR(counts[n], expected[n], 2) << n;
}

constexpr double kHalfStep = 0.3; // voxels: of the segments that are looked at

TEST_F(Picks, AreTheValueThatARayKeeps) {
    const auto extreme = [](bool most) {
        return [most](const std::vector<double>& values) {
            const auto at = most ? std::max_element(values.begin(), values.end())
                                 : std::min_element(values.begin(), values.end());
            return static_cast<std::size_t>(at - values.begin());
        };
    };
    const auto middle = [](const std::vector<double>& values) { return values.size() / 2; };
    for (const bool cut : {false, true}) {
        if (cut)
            scene_.cuts.planes.push_back(
                {glm::dvec3(info_.patientFromVoxel * glm::dvec4(20, 15, 38, 1)), {0.2, 0.1, -1}});
        scene_.mode = Mode::maximum;
        expectFound(extreme(true), 2 * kHalfStep);
        scene_.mode = Mode::minimum;
        expectFound(extreme(false), 2 * kHalfStep);
        scene_.mode = Mode::average;
        expectFound(middle, 2 * kHalfStep);
        scene_.mode = Mode::absorption; // no place of a sum tells more
        expectFound(middle, 2 * kHalfStep);
    }
}

TEST_F(Picks, AreTheFirstSurfaceThatShowsMost) {
    /// The first place behind a surface of one of the values; where there is none, of one of the others.
    const auto crossing = [](const std::vector<double>& of, const std::vector<double>& others = {}) {
        return [of, others](const std::vector<double>& values) {
            for (const std::vector<double>& surfaces : {of, others})
                for (std::size_t n = 1; n < values.size(); ++n)
                    for (const double value : surfaces)
                        if ((values[n] >= value) != (values[n - 1] >= value))
                            return n;
            return values.size();
        };
    };
    scene_.mode = Mode::isosurface;
    scene_.surfaces = {{60, {1, 1, 1}, 1}};
    expectFound(crossing({60}), 0.1);
    scene_.surfaces = {{60, {1, 1, 1}, 0.2}, {90, {1, 1, 1}, 0.9}};
    expectFound(crossing({90}, {60}), 0.1);
    scene_.surfaces = {{60, {1, 1, 1}, 0.9}, {90, {1, 1, 1}, 0.9}};
    expectFound(crossing({60, 90}), 0.1);
}

/// Beside a voxel opacity rises most where a dense function begins.
TEST_F(Picks, AreWhereOpacityRises) {
    scene_.volumes[0].transferFunction =
        TransferFunction::fromOpacity({{49.5, 0}, {50, 0.99}}, {{0, {1, 1, 1}}}, 1);
    expectFound(
        [](const std::vector<double>& values) {
            return static_cast<std::size_t>(
                std::find_if(values.begin(), values.end(), [](double v) { return v >= 50; }) -
                values.begin());
        },
        1.2);
}

/// A sheet of one voxel, which the mean of two layers hides: small volumes are looked through at level 0.
TEST(ThinSheets, ArePicked) {
    const ScratchFolder folder;
    VolumeInfo info;
    info.extentVoxels = {40, 36, 38};
    info.type = ValueType::i16;
    info.patientFromVoxel = glm::dmat4(1.5);
    info.patientFromVoxel[3] = {3, 4, 5, 1};
    FormulaSource source(info, [](const glm::dvec3& p) { return std::floor(p.y) == 20 ? 1000.0 : 0.0; });
    MemoryBudget ram("RAM", "--ram", kRamBytes);
    importToStore(source, folder / "v.zarr", ram, {});
    Looker looker(false);
    Scene scene = looker.opened(folder / "v.zarr");
    scene.mode = Mode::isosurface;
    scene.surfaces = {{600, {1, 1, 1}, 1}};
    scene.camera = fitCamera(info, View::anterior, Projection::parallel, kPicture);
    looker.wholeOf(looker.viewing->show(scene, false));
    const std::uint64_t question = looker.viewing->pick(0.5 * glm::dvec2(kPicture));
    ASSERT_TRUE(looker.comesTo(
        [&] { return looker.viewing->picked() && looker.viewing->picked()->number >= question; }));
    ASSERT_TRUE(looker.viewing->picked()->hit);
    EXPECT_NEAR(looker.viewing->picked()->voxel.y, 19.5 + 0.6, 0.05);
}

/// The state counts the bricks whose levels it has, and knows the budgets.
TEST_F(Picks, TheStateIsThatOfTheBricks) {
    scene_.volumes[0].transferFunction =
        TransferFunction::fromOpacity({{-1000, 0.01}, {900, 0.02}}, {{0, {1, 1, 1}}}, 1);
    looker_.viewing->showLevels(true);
    looker_.wholeOf(looker_.viewing->show(scene_, false));
    ASSERT_TRUE(looker_.comesTo([&] { return looker_.viewing->state().levels != nullptr; }));
    const ViewingState state = looker_.viewing->state();
    EXPECT_EQ(state.kind, ViewingState::Kind::open);
    EXPECT_EQ(state.brickGrid, glm::ivec3(2, 2, 3));
    ASSERT_EQ(state.levels->size(), 12u);
    EXPECT_EQ(state.bricks, 12u);
    std::size_t shown = 0;
    int finest = 5, coarsest = 0;
    for (const std::uint8_t level : *state.levels)
        if (level < 6) {
            ++shown;
            finest = std::min<int>(finest, level), coarsest = std::max<int>(coarsest, level);
        }
    EXPECT_GT(shown, 0u);
    EXPECT_EQ(state.bricksShown, shown);
    EXPECT_EQ(state.bricksAsWanted, shown) << "at rest";
    EXPECT_EQ(state.finestLevel, finest);
    EXPECT_EQ(state.coarsestLevel, coarsest);
    EXPECT_GT(state.chunksMissed, 0u);
    EXPECT_EQ(state.ramLimit, kRamBytes);
    EXPECT_EQ(state.gpuLimit, kGpuBytes);
    EXPECT_GT(state.ramUsed, 0u);
    EXPECT_GT(state.gpuUsed, 0u);
    EXPECT_EQ(state.movesLeft, 0u);
    EXPECT_EQ(state.damagedChunks, 0u);
    EXPECT_GE(state.pictures, 1u);
    EXPECT_NE(state.engine, "");
    EXPECT_FALSE(state.noStills || state.drawingStill || state.choosing || state.lightIsCoarse);
    looker_.viewing->showLevels(false);
    EXPECT_TRUE(looker_.comesTo([&] { return !looker_.viewing->state().levels; }));
}

} // namespace
} // namespace tessera::test

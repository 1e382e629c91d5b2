// tests/render/plan/drawn_part_test.cpp: the part of a volume that slices and cuts leave, against the cuts'
// own words; and the bricks that it leaves out.
#include "render/plan/drawn_part.h"

#include "core/base/error.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

VolumeInfo obliqueInfo() {
    VolumeInfo info;
    info.extentVoxels = {100, 70, 40};
    info.patientFromVoxel = patientFromVoxelOf({-30, 50, 7}, {0.8, 0, 0.1}, {0, 0.9, 0}, {0, 0.3, 1.5});
    return info;
}
glm::dvec3 inPatient(const VolumeInfo& info, const glm::dvec3& voxel) {
    return glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1));
}
bool holds(const DrawnPart& part, const glm::dvec3& voxel) {
    return part.meets(voxel, voxel);
}
std::vector<glm::dvec3> places(int count) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> x(0, 100), y(0, 70), z(0, 40);
    std::vector<glm::dvec3> all;
    for (int n = 0; n < count; ++n)
        all.emplace_back(x(random), y(random), z(random));
    return all;
}

TEST(DrawnPart, IsAllOfAVolumeWithoutCuts) {
    const DrawnPart part = drawnPart(Scene{}, obliqueInfo());
    EXPECT_FALSE(part.any() || part.slice || part.flat || part.cuts);
    EXPECT_TRUE(holds(part, {1, 2, 3}));
}

// Every place of a volume by the words of core/scene/cuts.h.
TEST(DrawnPart, IsWhatEachCutKeeps) {
    const VolumeInfo info = obliqueInfo();
    const CropBox patient{{-20, 60, 10}, {35, 100, 60}, CropBox::Space::patient, Keep::inside};
    const CropBox voxels{{10, 20, 5}, {60, 65, 30}, CropBox::Space::voxels, Keep::inside};
    const CutPlane plane{{10, 80, 30}, {1, -2, 0.5}, Keep::inside};
    CropBox hole = voxels;
    hole.keep = Keep::outside;
    CutPlane behind = plane;
    behind.keep = Keep::outside;
    const auto between = [](const CropBox& box, const glm::dvec3& p) {
        return glm::all(glm::lessThan(box.low, p)) && glm::all(glm::lessThan(p, box.high));
    };
    struct Case {
        Cuts cuts;
        std::function<bool(const glm::dvec3& voxel, const glm::dvec3& mm)> keeps;
        std::size_t slabs;
        bool others;
    };
    const auto before = [&](const glm::dvec3& mm) { return glm::dot(mm - plane.point, plane.normal) > 0; };
    const std::vector<Case> cases = {
        {{{patient}, {}, {}}, [&](auto&, auto& mm) { return between(patient, mm); }, 3, false},
        {{{voxels}, {}, {}}, [&](auto& v, auto&) { return between(voxels, v); }, 3, false},
        {{{}, {plane}, {}}, [&](auto&, auto& mm) { return before(mm); }, 1, false},
        {{{}, {behind}, {}}, [&](auto&, auto& mm) { return !before(mm); }, 1, false},
        {{{hole}, {}, {}}, [&](auto& v, auto&) { return !between(voxels, v); }, 0, true},
        {{{patient, voxels}, {plane}, {}},
         [&](auto& v, auto& mm) { return between(patient, mm) && between(voxels, v) && before(mm); },
         7,
         false},
        {{{patient, voxels, voxels}, {plane, plane, plane}, {}}, // more slabs than rays have
         [&](auto& v, auto& mm) { return between(patient, mm) && between(voxels, v) && before(mm); },
         8,
         true},
        {{{patient, hole}, {}, {}},
         [&](auto& v, auto& mm) { return between(patient, mm) && !between(voxels, v); },
         3,
         true},
    };
    for (std::size_t n = 0; n < cases.size(); ++n) {
        Scene scene;
        scene.cuts = cases[n].cuts;
        const DrawnPart part = drawnPart(scene, info);
        EXPECT_TRUE(part.any());
        EXPECT_EQ(part.slabs.size(), cases[n].slabs) << n;
        EXPECT_EQ(part.cuts != nullptr, cases[n].others) << n;
        EXPECT_FALSE(part.slice || part.flat);
        int kept = 0;
        for (const glm::dvec3& voxel : places(3000)) {
            const bool keeps = cases[n].keeps(voxel, inPatient(info, voxel));
            ASSERT_EQ(holds(part, voxel), keeps)
                << n << ": " << voxel.x << ", " << voxel.y << ", " << voxel.z;
            kept += keeps;
        }
        EXPECT_GT(kept, 30) << n;
        EXPECT_LT(kept, 2970) << n;
    }
}

TEST(DrawnPart, OfASliceIsItsThickness) {
    const VolumeInfo info = obliqueInfo();
    Scene scene;
    scene.mode = Mode::slice;
    for (const Orientation orientation : {Orientation::axial, Orientation::coronal, Orientation::sagittal})
        for (const double thickness : {0.0, 9.0}) {
            const int axis = orientation == Orientation::sagittal  ? 0
                             : orientation == Orientation::coronal ? 1
                                                                   : 2;
            const glm::dvec3 middle = inPatient(info, {50, 35, 20});
            for (const double off : {0.0, 4.0}) {
                scene.slice.orientation = orientation;
                scene.slice.thicknessMm = thickness;
                scene.slice.positionMm.reset();
                if (off != 0)
                    scene.slice.positionMm = middle[axis] + off;
                const DrawnPart part = drawnPart(scene, info);
                EXPECT_TRUE(part.slice);
                EXPECT_EQ(part.flat, thickness == 0);
                ASSERT_EQ(part.slabs.size(), 1u);
                int kept = 0;
                for (const glm::dvec3& voxel : places(2000)) {
                    const double apart = std::abs(inPatient(info, voxel)[axis] - middle[axis] - off);
                    if (std::abs(apart - thickness / 2) > 1e-9) {
                        ASSERT_EQ(holds(part, voxel), apart < thickness / 2);
                    }
                    kept += apart < thickness / 2;
                }
                EXPECT_EQ(kept > 0, thickness > 0);
            }
        }
}

// The rays of a slice seen from the front begin at its first slab's middle, to the last bit of its place.
TEST(DrawnPart, RaysOfASliceBeginAtIt) {
    const VolumeInfo info = obliqueInfo();
    Scene scene;
    scene.mode = Mode::slice;
    scene.slice.orientation = Orientation::coronal;
    scene.slice.thicknessMm = 6;
    const DrawnPart part = drawnPart(scene, info);
    const RaySlab<double>& slab = part.slabs[0];
    const auto framed = [&](const Camera& camera) {
        RayFrame<double> frame = rayFrame(camera, info, {30, 20}, 0.5);
        part.clip(frame);
        return frame;
    };
    Camera camera = sliceCamera(scene.slice, info, {30, 20});
    const RayFrame<double> frame = framed(camera), before = rayFrame(camera, info, {30, 20}, 0.5);
    EXPECT_EQ(frame.slabCount, 1);
    EXPECT_EQ(frame.slabs[0].normal, slab.normal);
    EXPECT_FALSE(frame.flat);
    EXPECT_EQ(frame.cuts, nullptr);
    EXPECT_NEAR(glm::dot(slab.normal, frame.centre), 0.5 * (slab.low + slab.high), 1e-9);
    EXPECT_NEAR(glm::length(glm::cross(frame.centre - before.centre, before.toCentre)), 0, 1e-7)
        << "along rays";
    // Not where rays run along the slab, nor from an eye.
    camera.position = camera.focalPoint + glm::dvec3(100, 1, 0);
    EXPECT_EQ(framed(camera).centre, rayFrame(camera, info, {30, 20}, 0.5).centre);
    const Camera eye = fitCamera(info, View::anterior, Projection::perspective, {30, 20});
    EXPECT_EQ(framed(eye).centre, rayFrame(eye, info, {30, 20}, 0.5).centre);
}

TEST(DrawnPart, ASlicesCameraFitsTheCrossSection) {
    VolumeInfo info;
    info.extentVoxels = {100, 70, 40};
    info.patientFromVoxel = patientFromVoxelOf({-30, 50, 7}, {0.8, 0, 0}, {0, 0.9, 0}, {0, 0, 1.5});
    const glm::dvec3 size = glm::dvec3(100, 70, 40) * glm::dvec3(0.8, 0.9, 1.5),
                     middle = inPatient(info, {50, 35, 20});
    SlicePlane slice;
    for (const glm::ivec2& picture : {glm::ivec2(100, 10), glm::ivec2(10, 100), glm::ivec2(50, 50)})
        for (const Orientation orientation :
             {Orientation::axial, Orientation::coronal, Orientation::sagittal}) {
            slice.orientation = orientation;
            const bool axial = orientation == Orientation::axial,
                       sagittal = orientation == Orientation::sagittal;
            const glm::dvec2 across = axial      ? glm::dvec2(size.x, size.y)
                                      : sagittal ? glm::dvec2(size.y, size.z)
                                                 : glm::dvec2(size.x, size.z);
            const Camera camera = sliceCamera(slice, info, picture);
            EXPECT_EQ(camera.projection, Projection::parallel);
            EXPECT_NEAR(glm::length(camera.focalPoint - middle), 0, 1e-9);
            const double wide = across.x * picture.y / picture.x;
            EXPECT_NEAR(camera.parallelScale, 1.03 * 0.5 * std::max(wide, across.y), 1e-9);
            EXPECT_NEAR(glm::length(camera.position - camera.focalPoint), 4 * camera.parallelScale, 1e-6);
            // A plane that misses the volume shows where that is.
            slice.positionMm = 1e4;
            EXPECT_NEAR(sliceCamera(slice, info, picture).parallelScale, camera.parallelScale, 1e-9);
            slice.positionMm.reset();
        }
    // A corner's cross-section is smaller, and in the picture's middle.
    slice.orientation = Orientation::oblique;
    slice.normal = {1, 1, 1};
    slice.point = inPatient(info, {1, 1, 1});
    const Camera corner = sliceCamera(slice, info, {50, 50});
    EXPECT_LT(corner.parallelScale, 10);
    EXPECT_LT(glm::length(corner.focalPoint - inPatient(info, {1, 1, 1})), 5);
}

Selection bricksOf(const VolumeInfo& info, const std::function<int(std::size_t)>& levelOf) {
    Selection s;
    s.bricks = brickGrid(info.extentVoxels);
    for (std::size_t b = 0; b < cellCount(s.bricks); ++b) {
        s.levels.push_back(static_cast<std::uint8_t>(levelOf(b)));
        ++s.counts[s.levels.back()];
    }
    return s;
}

// A brick goes where the part is further from it than its samples reach, and stays a little nearer.
TEST(DrawnPart, BricksBeyondTheReachOfSamplesAreLeftOut) {
    VolumeInfo info;
    info.extentVoxels = {130, 70, 40}; // 5 x 3 x 2 bricks
    struct Case {
        int level;
        bool mixed, lit;
        double reach;
    };
    for (const Case& c : {Case{0, false, false, 2}, Case{0, false, true, 4}, Case{2, false, false, 5},
                          Case{2, false, true, 13}, Case{1, true, false, 33}, Case{1, true, true, 65}})
        for (const double off : {-0.01, 0.01}) {
            Scene scene;
            const double low = 32 + c.reach + off;
            scene.cuts.boxes = {{{low, 0, 0}, {low + 1, 70, 40}, CropBox::Space::voxels, Keep::inside}};
            const DrawnPart part = drawnPart(scene, info);
            Selection s = bricksOf(info, [&](std::size_t b) {
                return b % 5 == 4 && b > 5 ? int{Selection::kEmpty} : c.level + (c.mixed && b % 2 ? 1 : 0);
            });
            const std::size_t empty = s.counts[Selection::kEmpty];
            const std::size_t left = leaveOutUndrawn(s, part, info, c.lit);
            std::array<std::size_t, kLevelCount + 1> counts{};
            for (std::size_t b = 0; b < s.levels.size(); ++b) {
                ++counts[s.levels[b]];
                if (b % 5 == 0) {
                    EXPECT_EQ(s.levels[b] == Selection::kEmpty, off > 0) << c.level << ", " << c.reach;
                }
            }
            EXPECT_EQ(counts, s.counts);
            EXPECT_EQ(s.counts[Selection::kEmpty], empty + left);
        }
    Selection whole = bricksOf(info, [](std::size_t) { return 0; });
    EXPECT_EQ(leaveOutUndrawn(whole, DrawnPart{}, info, true), 0u);
    EXPECT_EQ(whole.shownBricks(), 30u);
}

} // namespace
} // namespace tessera

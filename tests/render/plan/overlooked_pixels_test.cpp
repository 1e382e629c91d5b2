// tests/render/plan/overlooked_pixels_test.cpp: overlooked pixels are those of a search through all corners
// of all cells.
#include "render/plan/overlooked_pixels.h"

#include "tests/support/surface_fixture.h" // Stored

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

constexpr double kFar = 1e9;

/// Columns and rows from low up to, not with, high.
struct Box {
    glm::dvec2 low{kFar}, high{-kFar};
};

/// The box around a cell's corners; nothing where one is not before the eye.
Box cornersOf(const RayPlane& plane, const VolumeInfo& info, const glm::ivec2& size, const glm::ivec3& low,
              const glm::ivec3& high) {
    Box box;
    const double right = glm::dot(plane.right, plane.right), up = glm::dot(plane.up, plane.up);
    for (int n = 0; n < 8; ++n) {
        const glm::dvec3 voxel(n & 1 ? high.x : low.x, n & 2 ? high.y : low.y, n & 4 ? high.z : low.z);
        const glm::dvec3 at(info.patientFromVoxel * glm::dvec4(voxel, 1));
        glm::dvec3 onPlane = at - plane.centre;
        if (plane.perspective) {
            const glm::dvec3 eye = plane.centre - plane.toCentre;
            const double depth = glm::dot(at - eye, plane.forward);
            if (!(depth > 0))
                return {};
            onPlane = (at - eye) * (glm::dot(plane.toCentre, plane.forward) / depth) - plane.toCentre;
        }
        const glm::dvec2 place((glm::dot(onPlane, plane.right) / right + 1) / 2 * size.x,
                               (1 - glm::dot(onPlane, plane.up) / up) / 2 * size.y);
        box.low = glm::min(box.low, place);
        box.high = glm::max(box.high, place);
    }
    return box;
}

std::vector<std::uint32_t> searched(const FramePlan& plan, const Image& middles, int& small, int& clipped) {
    const VolumeInfo& info = plan.info();
    const RayPlane plane = rayPlane(plan.view.camera, info, middles.size);
    const glm::ivec3 bricks = brickGrid(info.extentVoxels);
    std::vector<bool> overlooked(middles.pixels.size(), false);
    for (int k = 0; k < cellGrid(info.extentVoxels).z; ++k)
        for (int j = 0; j < cellGrid(info.extentVoxels).y; ++j)
            for (int i = 0; i < cellGrid(info.extentVoxels).x; ++i) {
                const glm::ivec3 cell(i, j, k), in = cell % kCellsPerBrick;
                const std::uint64_t mask =
                    plan.layer().occupancy.masks()[linearIndex(cell / kCellsPerBrick, bricks)];
                if ((mask >> (in.x + 4 * in.y + 16 * in.z) & 1) == 0)
                    continue;
                const glm::ivec3 low = cell * kCellExtent,
                                 high = glm::min(low + kCellExtent, info.extentVoxels);
                const Box box = cornersOf(plane, info, middles.size, low, high);
                if (box.low.x == kFar)
                    continue;
                const auto from = glm::ivec2(glm::max(glm::floor(box.low), 0.0));
                const auto to =
                    glm::min(glm::ivec2(glm::ceil(glm::clamp(box.high, -1.0, 1000.0))), middles.size);
                bool shown = false;
                for (int y = from.y; y < to.y; ++y)
                    for (int x = from.x; x < to.x; ++x)
                        shown = shown || middles.at(x, y).a > 0;
                const glm::dvec2 extent = box.high - box.low;
                const bool large = std::max(extent.x, extent.y) > 8;
                const bool thin = to.x - from.x <= 1 || to.y - from.y <= 1;
                if (shown || (large && !thin))
                    continue;
                large ? ++clipped : ++small;
                for (int y = from.y; y < to.y; ++y)
                    for (int x = from.x; x < to.x; ++x)
                        overlooked[static_cast<std::size_t>(y * middles.size.x + x)] = true;
            }
    std::vector<std::uint32_t> pixels;
    for (std::uint32_t n = 0; n < overlooked.size(); ++n)
        if (overlooked[n])
            pixels.push_back(n);
    return pixels;
}

/// A few thick rods, apart from one another.
Stored rods() {
    return Stored(
        [](const glm::dvec3& p) { return std::sin(0.31 * p.x) * std::cos(0.23 * p.y) > 0.4 ? 1000.0 : 0.0; },
        {75, 44, 61}, true);
}

TEST(OverlookedPixels, AreThoseOfASearchThroughAllCells) {
    const Stored stored = rods();
    std::mt19937 random(3);
    int small = 0, clipped = 0, someCases = 0;
    for (const bool perspective : {false, true})
        for (const glm::ivec2& size : {glm::ivec2(23, 19), glm::ivec2(46, 31), glm::ivec2(97, 83)})
            for (const double zoom : {0.21, 0.55, 1.07}) {
                Scene scene = stored.scene({}, 0, 8);
                scene.imageSize = size;
                scene.volumes[0].transferFunction =
                    TransferFunction::fromExtinction({{500, 0}, {501, 1}}, {{0, {1, 1, 1}}});
                Camera camera = fitCamera(stored.info, View::anterior,
                                          perspective ? Projection::perspective : Projection::parallel, size);
                camera.parallelScale *= zoom;
                camera.position += 0.317 * (camera.focalPoint - camera.position);
                camera.viewAngle *= zoom;
                const glm::dvec3 aside(3.17, 0, 2.71);
                camera.position += aside, camera.focalPoint += aside; // still along an axis
                scene.camera = camera;
                const auto prepared = stored.prepare(scene);
                ASSERT_TRUE(prepared->p.layer().occupancy.exists());
                for (const double share : {0.0, 0.02, 0.1, 1.0}) {
                    Image middles(size);
                    for (glm::vec4& pixel : middles.pixels)
                        pixel.a = std::bernoulli_distribution(share)(random) ? 1e-3f : 0.0f;
                    const auto expected = searched(prepared->p, middles, small, clipped);
                    EXPECT_EQ(overlookedPixels(prepared->p, middles), expected)
                        << size.x << ", " << zoom << ", " << share << (perspective ? ", perspective" : "");
                    someCases += !expected.empty() && expected.size() < middles.pixels.size();
                    EXPECT_TRUE(share < 1 || expected.empty());
                }
            }
    EXPECT_GT(small, 100);
    EXPECT_GT(clipped, 10);
    EXPECT_GT(someCases, 20);
}

TEST(OverlookedPixels, AreNoneWithoutAMapAndNoneBehindTheEye) {
    const Stored stored = rods();
    Scene scene = stored.scene({}, 0, 24);
    scene.volumes[0].transferFunction =
        TransferFunction::fromExtinction({{500, 0}, {501, 1}}, {{0, {1, 1, 1}}});
    scene.quality.skipping = false;
    const Image black({24, 24});
    EXPECT_TRUE(overlookedPixels(stored.prepare(scene)->p, black).empty());
    scene.quality.skipping = true;
    EXPECT_FALSE(overlookedPixels(stored.prepare(scene)->p, black).empty());
    Camera away = fitCamera(stored.info, View::anterior, Projection::perspective, {24, 24});
    away.focalPoint = away.position + (away.position - away.focalPoint);
    scene.camera = away;
    EXPECT_TRUE(overlookedPixels(stored.prepare(scene)->p, black).empty());
}

} // namespace
} // namespace tessera::test

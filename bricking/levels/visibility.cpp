// bricking/levels/visibility.cpp: see visibility.h.
#include "bricking/levels/visibility.h"

#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <memory>

namespace tessera {

std::vector<float> visibilityFactors(std::span<const SeenBrick> seen, const Selection& selection,
                                     std::span<const float> last) {
    TESSERA_CHECK(seen.size() == selection.levels.size());
    TESSERA_CHECK(last.empty() || last.size() == seen.size());
    std::vector<float> factors(seen.size());
    for (std::size_t brick = 0; brick < seen.size(); ++brick) {
        const SeenBrick& s = seen[brick];
        const double most = static_cast<double>(s.rays) * SeenBrick::kLightOfRay;
        const double light = s.rays == 0 ? 1.0 : std::min(s.light / most, 1.0);
        const float now = std::max(static_cast<float>(light), kHiddenVisibility);
        factors[brick] = now;
        if (last.empty())
            continue;
        const float before = last[brick];
        if (now <= 2 * before && 2 * now >= before)
            factors[brick] = before;
        else if (now < before && selection.levels[brick] < kLevelCount - 1)
            factors[brick] = std::max(now, before / 2);
    }
    return factors;
}

namespace {

constexpr int kPixelsPerRay = 4; // along each axis: the smallest relevant bricks cover a few pixels
constexpr int kMostRays = 512;   // along each axis, so that sums of whole numbers do not overflow
constexpr double kWhole = 256;   // units of light: whole numbers, so that sums do not depend on their order

struct Seen { // sums over the rays that enter a brick
    std::atomic<std::uint32_t> light = 0, rays = 0;
};

/// Walks a ray through the grid of bricks; visit(brick number, path in bricks).
template <typename Visit>
void walk(const glm::dvec3& base, const glm::dvec3& direction, double nearest, const glm::ivec3& grid,
          const Visit& visit) {
    double t0 = nearest, t1 = std::numeric_limits<double>::max();
    for (int axis = 0; axis < 3; ++axis) {
        const double o = base[axis], d = direction[axis];
        if (d == 0) {
            if (o < 0 || o > grid[axis])
                return;
            continue;
        }
        const double a = (0 - o) / d, b = (grid[axis] - o) / d;
        t0 = std::max(t0, std::min(a, b));
        t1 = std::min(t1, std::max(a, b));
    }
    if (!(t1 > t0))
        return;
    const glm::dvec3 start = base + t0 * direction;
    glm::ivec3 brick = glm::clamp(glm::ivec3(glm::floor(start)), glm::ivec3(0), grid - 1);
    const int most = grid.x + grid.y + grid.z + 3;
    double t = t0;
    for (int step = 0; step < most && t < t1; ++step) {
        double leave = t1;
        int across = -1;
        for (int axis = 0; axis < 3; ++axis) {
            if (direction[axis] == 0)
                continue;
            const double face = brick[axis] + (direction[axis] > 0 ? 1 : 0);
            const double at = (face - base[axis]) / direction[axis];
            if (at < leave) {
                leave = at;
                across = axis;
            }
        }
        visit(linearIndex(brick, grid), std::max(leave - t, 0.0));
        if (across < 0)
            return;
        brick[across] += direction[across] > 0 ? 1 : -1;
        if (brick[across] < 0 || brick[across] >= grid[across])
            return;
        t = std::max(t, leave);
    }
}

} // namespace

std::vector<float> predictVisibility(const LevelErrors& errors, const Camera& camera, const VolumeInfo& info,
                                     const glm::ivec2& imageSize, int threads) {
    const glm::ivec3 grid = errors.bricks;
    const std::size_t count = cellCount(grid);
    const auto seen = std::make_unique<Seen[]>(count);
    // Rays in units of bricks: the affine to the patient and the bricks' size are folded into one matrix.
    const RayPlane plane = rayPlane(camera, info, imageSize);
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    const glm::dmat3 linear = glm::dmat3(voxelFromPatient) * (1.0 / kBrickExtent);
    const glm::dvec3 centre =
        glm::dvec3(voxelFromPatient * glm::dvec4(plane.centre, 1)) * (1.0 / kBrickExtent);
    const glm::dvec3 right = linear * plane.right, up = linear * plane.up;
    const glm::dvec3 along = linear * (plane.perspective ? plane.toCentre : plane.forward);
    const glm::ivec2 rays = glm::clamp(imageSize / kPixelsPerRay, glm::ivec2(1), glm::ivec2(kMostRays));
    parallelFor(static_cast<std::size_t>(rays.y), threads, [&](std::size_t row) {
        for (int column = 0; column < rays.x; ++column) {
            const double x = 2 * (column + 0.5) / rays.x - 1;
            const double y = 1 - 2 * (static_cast<double>(row) + 0.5) / rays.y;
            const glm::dvec3 offset = x * right + y * up;
            const glm::dvec3 line = plane.perspective ? along + offset : along;
            const double length = glm::length(line);
            double light = 1;
            walk(centre + offset, line / length,
                 plane.perspective ? -length : -std::numeric_limits<double>::max(), grid,
                 [&](std::size_t brick, double path) {
                     seen[brick].light += static_cast<std::uint32_t>(light * kWhole);
                     ++seen[brick].rays;
                     const auto through = static_cast<double>(errors.transmittances[brick]);
                     if (through < 1)
                         light *= std::pow(std::max(through, 1e-6), path);
                 });
        }
    });
    std::vector<float> visible(count);
    for (std::size_t brick = 0; brick < count; ++brick) {
        const std::uint32_t entered = seen[brick].rays;
        visible[brick] = entered == 0 ? 1.0f
                                      : std::clamp(static_cast<float>(seen[brick].light / (kWhole * entered)),
                                                   kHiddenVisibility, 1.0f);
    }
    return visible;
}

} // namespace tessera

// render/geometry/bit_rays.cpp: see bit_rays.h.
#include "render/geometry/bit_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {
namespace {

/// Rounding of a hit's place, voxels.
constexpr double kSlack = 1e-3;
/// The centres of a plane's voxels lie at most half a voxel above it, along the axis that it is steepest to.
/// So V is at most 3/2 less the height, in voxels, and 0 from there on.
constexpr double kHighest = 1.5 + kSlack;

} // namespace

BitRays::BitRays(const MeshBits& bits, double threshold)
    : bits_(bits), turn_(bits.grid().fromPatient), threshold_(threshold) {}

double BitRays::reach(const glm::dvec3& place, const glm::dvec3& direction, double fromMm, double mostMm,
                      std::uint64_t key, double cosine) const {
    const VoxelGrid& grid = bits_.grid();
    const glm::dvec3 start(grid.fromPatient * glm::dvec4(place, 1)), along = turn_ * direction;
    double from = fromMm, to = mostMm; // where values may be: a voxel around the grid
    for (int axis = 0; axis < 3; ++axis) {
        if (along[axis] == 0) {
            if (start[axis] < -1 || start[axis] > grid.extent[axis] + 1)
                return mostMm;
            continue;
        }
        const double a = (-1 - start[axis]) / along[axis],
                     b = (grid.extent[axis] + 1 - start[axis]) / along[axis];
        from = std::max(from, std::min(a, b));
        to = std::min(to, std::max(a, b));
    }
    if (!(from < to))
        return mostMm;
    const double step = kStep * grid.edgeMm, begin = fromMm + step * unitFraction(mixedBits(key));
    const double u = bits_.hasAlphas() ? unitFraction(mixedBits(key + 1)) : 0;
    const double enough = u < 1 ? -std::log1p(-u) : std::numeric_limits<double>::max();
    const double rise = cosine / grid.edgeMm; // height, in voxels a mm
    double passed = 0;
    const auto most = static_cast<std::int64_t>(std::ceil((to - begin) / step));
    for (auto n = static_cast<std::int64_t>(std::max(0.0, std::ceil((from - begin) / step))); n < most;) {
        const double mm = begin + static_cast<double>(n) * step;
        const glm::vec3 at(start + mm * along);
        if (const int clear = bits_.clearVoxels(at); clear > 0) {
            n += static_cast<std::int64_t>(clear / kStep);
            continue;
        }
        const double itself = cosine > 0 ? kHighest - mm * rise : 0; // V of the plane that it comes from
        if (static_cast<double>(bits_.coverage(at)) >= std::max(threshold_, itself))
            return mm;
        if (bits_.hasAlphas() && !(itself > 0)) {
            passed += kStep * static_cast<double>(bits_.thickness(at));
            if (passed > enough)
                return mm;
        }
        ++n;
    }
    return mostMm;
}

} // namespace tessera

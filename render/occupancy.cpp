// render/occupancy.cpp: see occupancy.h.
#include "render/occupancy.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

/// Cells around a cell that a point in it can reach at a level. Interpolation between samples of level l
/// reaches voxels up to 1.5 * 2^l away (a sample stands for 2^l voxels around its centre); the statistics'
/// apron covers one voxel, which is all of it at level 0 (half a voxel to the next centre and half a voxel of
/// its own).
int reachCells(int level) {
    if (level == 0)
        return 0;
    const double voxels = 1.5 * (1 << level) - 1;
    return static_cast<int>(std::ceil(voxels / kCellExtent));
}

/// Chebyshev distance transform by the two raster passes of a 26-neighbour chamfer, which is exact for this
/// metric. In: 0 occupied, 255 empty. Out: distance, saturating at 255.
void distanceTransform(std::vector<std::uint8_t>& map, const glm::ivec3& grid) {
    const auto pass = [&](bool forward) {
        const int sign = forward ? -1 : 1;
        for (int kk = 0; kk < grid.z; ++kk)
            for (int jj = 0; jj < grid.y; ++jj)
                for (int ii = 0; ii < grid.x; ++ii) {
                    const glm::ivec3 at =
                        forward ? glm::ivec3(ii, jj, kk) : grid - 1 - glm::ivec3(ii, jj, kk);
                    std::uint8_t& here = map[linearIndex(at, grid)];
                    if (here == 0)
                        continue;
                    int best = here;
                    const auto visit = [&](int dx, int dy, int dz) {
                        const glm::ivec3 near = at + glm::ivec3(dx, dy, dz);
                        if (near.x < 0 || near.y < 0 || near.z < 0 || near.x >= grid.x || near.y >= grid.y ||
                            near.z >= grid.z)
                            return;
                        best = std::min(best, map[linearIndex(near, grid)] + 1);
                    };
                    for (int dy = -1; dy <= 1; ++dy)
                        for (int dx = -1; dx <= 1; ++dx)
                            visit(dx, dy, sign);
                    for (int dx = -1; dx <= 1; ++dx)
                        visit(dx, sign, 0);
                    visit(sign, 0, 0);
                    here = static_cast<std::uint8_t>(std::min(best, 255));
                }
    };
    pass(true);
    pass(false);
}

} // namespace

Occupancy makeOccupancy(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
                        const Selection& selection, Ledger& ram) {
    Occupancy o;
    o.cells = statistics.cells;
    const int reach = reachCells(selection.level);
    o.charge = ram.charge(cellCount(o.cells) * (reach > 0 ? 2 : 1), "the occupancy map");
    o.distance.resize(cellCount(o.cells));
    glm::ivec3 at(0);
    const auto physical = [&](float stored) {
        return info.rescaleSlope * static_cast<double>(stored) + info.rescaleIntercept;
    };
    for (at.z = 0; at.z < o.cells.z; ++at.z)
        for (at.y = 0; at.y < o.cells.y; ++at.y)
            for (at.x = 0; at.x < o.cells.x; ++at.x) {
                const std::size_t cell = linearIndex(at, o.cells);
                float lo = statistics.cellMin[cell], hi = statistics.cellMax[cell];
                const std::size_t brick = linearIndex(at / kCellsPerBrick, selection.bricks);
                if (selection.states[brick] == BrickState::empty) {
                    lo = std::min(lo, selection.means[brick]); // its samples read as the mean
                    hi = std::max(hi, selection.means[brick]);
                }
                const double a = physical(lo), b = physical(hi);
                o.distance[cell] = table.emptyOver(std::min(a, b), std::max(a, b)) ? 0 : 1;
            }
    // A blend of two hulls whose extinction is 0 may cross values whose extinction is not, where the hulls do
    // not overlap. At level 0 the aprons make neighbouring hulls overlap; coarser levels reach further than
    // the apron, so a cell is empty there only if the hull over its whole reach is.
    if (reach > 0) {
        std::vector<std::uint8_t> occupied = o.distance;
        glm::ivec3 near(0);
        for (at.z = 0; at.z < o.cells.z; ++at.z)
            for (at.y = 0; at.y < o.cells.y; ++at.y)
                for (at.x = 0; at.x < o.cells.x; ++at.x) {
                    std::uint8_t& here = occupied[linearIndex(at, o.cells)];
                    if (here)
                        continue;
                    float lo = INFINITY, hi = -INFINITY;
                    const glm::ivec3 first = glm::max(at - reach, glm::ivec3(0));
                    const glm::ivec3 last = glm::min(at + reach, o.cells - 1);
                    for (near.z = first.z; near.z <= last.z; ++near.z)
                        for (near.y = first.y; near.y <= last.y; ++near.y)
                            for (near.x = first.x; near.x <= last.x; ++near.x) {
                                const std::size_t cell = linearIndex(near, o.cells);
                                const std::size_t brick =
                                    linearIndex(near / kCellsPerBrick, selection.bricks);
                                lo = std::min(lo, statistics.cellMin[cell]);
                                hi = std::max(hi, statistics.cellMax[cell]);
                                if (selection.states[brick] == BrickState::empty) {
                                    lo = std::min(lo, selection.means[brick]);
                                    hi = std::max(hi, selection.means[brick]);
                                }
                            }
                    const double a = physical(lo), b = physical(hi);
                    here = table.emptyOver(std::min(a, b), std::max(a, b)) ? 0 : 1;
                }
        o.distance = std::move(occupied);
    }
    for (std::uint8_t& cell : o.distance) {
        o.occupiedCells += cell;
        cell = cell ? 0 : 255;
    }
    distanceTransform(o.distance, o.cells);
    return o;
}

} // namespace tessera

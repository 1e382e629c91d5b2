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
    o.charge = ram.charge(cellCount(o.cells), "the occupancy map");
    o.distance.resize(cellCount(o.cells));
    const auto emptyOver = [&](float lo, float hi) {
        const double a = info.rescaleSlope * static_cast<double>(lo) + info.rescaleIntercept;
        const double b = info.rescaleSlope * static_cast<double>(hi) + info.rescaleIntercept;
        return table.emptyOver(std::min(a, b), std::max(a, b));
    };
    // The hull of all samples that cells of a box can contribute; stops early once it is not empty.
    const auto emptyIn = [&](const glm::ivec3& first, const glm::ivec3& last) {
        float lo = INFINITY, hi = -INFINITY;
        glm::ivec3 near(0);
        for (near.z = first.z; near.z <= last.z; ++near.z)
            for (near.y = first.y; near.y <= last.y; ++near.y)
                for (near.x = first.x; near.x <= last.x; ++near.x) {
                    const std::size_t cell = linearIndex(near, o.cells);
                    const std::size_t brick = linearIndex(near / kCellsPerBrick, selection.bricks);
                    lo = std::min(lo, statistics.cellMin[cell]);
                    hi = std::max(hi, statistics.cellMax[cell]);
                    if (selection.levels[brick] == Selection::kEmpty) {
                        lo = std::min(lo, selection.means[brick]); // its samples read as the mean
                        hi = std::max(hi, selection.means[brick]);
                    }
                }
        return emptyOver(lo, hi);
    };
    // A blend of two hulls whose extinction is 0 may cross values whose extinction is not, where the hulls do
    // not overlap. At level 0 the aprons make neighbouring hulls overlap; coarser levels reach further than
    // the apron, so a cell is empty there only if the hull over its whole reach is.
    glm::ivec3 brick(0);
    for (brick.z = 0; brick.z < selection.bricks.z; ++brick.z)
        for (brick.y = 0; brick.y < selection.bricks.y; ++brick.y)
            for (brick.x = 0; brick.x < selection.bricks.x; ++brick.x) {
                int coarsest = 0;
                glm::ivec3 n(0);
                const glm::ivec3 low = glm::max(brick - 1, glm::ivec3(0));
                const glm::ivec3 high = glm::min(brick + 1, selection.bricks - 1);
                for (n.z = low.z; n.z <= high.z; ++n.z)
                    for (n.y = low.y; n.y <= high.y; ++n.y)
                        for (n.x = low.x; n.x <= high.x; ++n.x)
                            if (const int level = selection.levels[linearIndex(n, selection.bricks)];
                                level != Selection::kEmpty)
                                coarsest = std::max(coarsest, level);
                const int reach = reachCells(coarsest);
                const glm::ivec3 first = brick * kCellsPerBrick;
                const glm::ivec3 end = glm::min(first + kCellsPerBrick, o.cells);
                glm::ivec3 at(0);
                for (at.z = first.z; at.z < end.z; ++at.z)
                    for (at.y = first.y; at.y < end.y; ++at.y)
                        for (at.x = first.x; at.x < end.x; ++at.x) {
                            const bool empty =
                                emptyIn(at, at) && (reach == 0 || emptyIn(glm::max(at - reach, glm::ivec3(0)),
                                                                          glm::min(at + reach, o.cells - 1)));
                            o.distance[linearIndex(at, o.cells)] = empty ? 255 : 0;
                            o.occupiedCells += empty ? 0 : 1;
                        }
            }
    distanceTransform(o.distance, o.cells);
    return o;
}

} // namespace tessera

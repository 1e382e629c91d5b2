// render/empty_space/brick_proof.cpp: see brick_proof.h.
#include "render/empty_space/brick_proof.h"

#include "render/contract/level_map.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

namespace tessera {
namespace {

template <typename Visit> void forEachCell(const glm::ivec3& cells, const Visit& visit) {
    glm::ivec3 at(0);
    for (at.z = 0; at.z < cells.z; ++at.z)
        for (at.y = 0; at.y < cells.y; ++at.y)
            for (at.x = 0; at.x < cells.x; ++at.x)
                visit(at);
}

/// Cells that hold the samples that points of a cell can reach in a brick of this level, along one axis that
/// both share. Interpolation reaches one sample beyond the cell at levels whose samples are no larger than a
/// cell (at level 0 the cell's own range covers it). Of the two samples of level 4, cells at the ends reach
/// only the nearer.
Span reachedAlong(int level, int cell, int cells) {
    Span span{cell, cell};
    if (level == 4)
        span = {cell == kCellsPerBrick - 1 ? kCellsPerBrick / 2 : 0,
                cell == 0 ? kCellsPerBrick / 2 - 1 : kCellsPerBrick - 1};
    else if (level > 0)
        span = {cell - 1, cell + 1};
    return {std::clamp(span.first, 0, cells - 1), std::clamp(span.last, 0, cells - 1)};
}

/// Cells under the outermost samples of a brick, on the side that faces against d.
Span outermost(int level, int d, int cells) {
    const int deep = level == 4 ? kCellsPerBrick / 2 : 1;
    return d > 0 ? Span{0, std::min(deep, cells) - 1} : Span{std::max(cells - deep, 0), cells - 1};
}

} // namespace

BrickProof::BrickProof(const OccupancyInput& input, const std::vector<glm::vec2>& wide, std::uint32_t finest)
    : in_(input), wide_(wide), zero_(input.table, input.info) {
    for (std::uint32_t other = 0; other < edges_.size(); ++other)
        for (std::uint32_t facing = 0; facing < edges_.size(); ++facing) {
            const float reach = edgeReach<float>(other, facing, in_.edgeFunction, finest).other;
            edges_[other][facing] = {static_cast<int>(std::ceil(reach / float{kCellExtent})),
                                     reach == halfSample<float>(0)};
        }
}

Hull BrickProof::rangeOver(const glm::ivec3& firstCell, const Span& x, const Span& y, const Span& z) const {
    Hull hull;
    for (int k = z.first; k <= z.last; ++k)
        for (int j = y.first; j <= y.last; ++j)
            for (int i = x.first; i <= x.last; ++i)
                hull.add(cellRange(firstCell + glm::ivec3(i, j, k)));
    return hull;
}

/// Neighbours with weight in the brick whose samples the cells' own ranges do not cover.
void BrickProof::findNeighbours(const glm::ivec3& brick, int level, bool everyOne) {
    count_ = 0;
    constexpr std::uint8_t kOutside = 255;
    constexpr std::array<int, 3> kSteps = {1, 3, 9};
    std::array<std::uint8_t, 27> levels; // of the brick and its neighbours, x fastest
    std::uint8_t any = 0;
    std::size_t place = 0;
    glm::ivec3 side(0);
    for (side.z = -1; side.z <= 1; ++side.z)
        for (side.y = -1; side.y <= 1; ++side.y)
            for (side.x = -1; side.x <= 1; ++side.x, ++place) {
                const glm::ivec3 at = brick + side, &bricks = in_.selection.bricks;
                const bool inside = static_cast<unsigned>(at.x) < static_cast<unsigned>(bricks.x) &&
                                    static_cast<unsigned>(at.y) < static_cast<unsigned>(bricks.y) &&
                                    static_cast<unsigned>(at.z) < static_cast<unsigned>(bricks.z);
                levels[place] = inside ? in_.selection.levels[linearIndex(at, bricks)] : kOutside;
                any = static_cast<std::uint8_t>(any | (inside ? levels[place] : 0));
            }
    // Bricks of level 0 interpolate as one, and each cell's own range covers the layer of samples that it
    // reaches.
    if (any == 0 && edges_[0][0].layers <= 1 && (!everyOne || edges_[0][0].plain))
        return;
    place = 0;
    for (side.z = -1; side.z <= 1; ++side.z)
        for (side.y = -1; side.y <= 1; ++side.y)
            for (side.x = -1; side.x <= 1; ++side.x, ++place) {
                if (side == glm::ivec3(0) || levels[place] == kOutside)
                    continue;
                Neighbour& n = neighbours_[static_cast<std::size_t>(count_)];
                n.side = side;
                n.level = levels[place];
                n.plain = true;
                n.layers = glm::ivec3(0);
                bool reaches = true, deep = false;
                for (int axis = 0; axis < 3; ++axis) {
                    if (side[axis] == 0)
                        continue;
                    const std::size_t facing =
                        place - static_cast<std::size_t>(side[axis] * kSteps[static_cast<std::size_t>(axis)]);
                    const Edge& edge = edges_[levels[place]][levels[facing]];
                    n.layers[axis] = edge.layers;
                    reaches = reaches && n.layers[axis] > 0;
                    deep = deep || n.layers[axis] > 1;
                    n.plain = n.plain && edge.plain;
                }
                if (everyOne) {
                    if (in_.edgeFunction == EdgeFunction::nearest) {
                        n.plain = false;
                        n.layers = glm::ivec3(1);
                    }
                } else if (!reaches || (level == 0 && n.level == 0 && !deep))
                    continue;
                n.brick = brick + side;
                ++count_;
            }
}

void BrickProof::addNeighbour(const Neighbour& n, const glm::ivec3& firstCell, const glm::ivec3& cells,
                              CellHulls& hulls) const {
    glm::ivec3 first(0), end = cells;
    std::array<Span, 3> crossed;
    for (int axis = 0; axis < 3; ++axis) {
        if (n.side[axis] == 0)
            continue;
        if (n.side[axis] > 0)
            first[axis] = std::max(cells[axis] - n.layers[axis], 0);
        else
            end[axis] = std::min(n.layers[axis], cells[axis]);
        const int there =
            std::min(kCellsPerBrick, in_.statistics.cells[axis] - n.brick[axis] * kCellsPerBrick);
        crossed[static_cast<std::size_t>(axis)] = outermost(n.level, n.side[axis], there);
    }
    glm::ivec3 at(0);
    for (at.z = first.z; at.z < end.z; ++at.z)
        for (at.y = first.y; at.y < end.y; ++at.y)
            for (at.x = first.x; at.x < end.x; ++at.x) {
                Hull& hull = hulls[cellBit(at)];
                if (isValue(n.level)) {
                    hull.add(rangeOf(n.brick, n.level));
                    continue;
                }
                std::array<Span, 3> spans = crossed;
                bool beside = true; // the cell touches the neighbouring brick
                for (int axis = 0; axis < 3; ++axis)
                    if (n.side[axis] == 0)
                        spans[static_cast<std::size_t>(axis)] = reachedAlong(n.level, at[axis], cells[axis]);
                    else
                        beside = beside && at[axis] == (n.side[axis] > 0 ? cells[axis] - 1 : 0);
                Hull there = rangeOver(n.brick * kCellsPerBrick, spans[0], spans[1], spans[2]);
                if (n.level == 0 && beside) {
                    // One layer of voxels, which the range of the current cell covers too: it is in both
                    // ranges.
                    const Hull own = cellRange(firstCell + at);
                    there.lo = std::max(there.lo, own.lo), there.hi = std::min(there.hi, own.hi);
                    there.shows &= own.shows;
                }
                hull.add(there);
            }
}

glm::ivec3 BrickProof::rangesAmong(const glm::ivec3& brick, CellHulls& hulls) const {
    const int level = levelOf(brick);
    const glm::ivec3 firstCell = brick * kCellsPerBrick;
    const glm::ivec3 cells = glm::min(glm::ivec3(kCellsPerBrick), in_.statistics.cells - firstCell);
    forEachCell(cells, [&](const glm::ivec3& at) {
        hulls[cellBit(at)] = isValue(level) ? rangeOf(brick, level) : cellRange(firstCell + at);
    });
    if (level > 0 && !isValue(level))
        for (int axis = 0; axis < 3; ++axis) { // the samples that a point reaches form a box: axis by axis
            const CellHulls before = hulls;
            const int step = axis == 0 ? 1 : axis == 1 ? 4 : 16;
            forEachCell(cells, [&](const glm::ivec3& at) {
                const Span span = reachedAlong(level, at[axis], cells[axis]);
                const std::size_t line = cellBit(at) - static_cast<std::size_t>(step * at[axis]);
                for (int i = span.first; i <= span.last; ++i)
                    hulls[cellBit(at)].add(before[line + static_cast<std::size_t>(step * i)]);
            });
        }
    for (int n = 0; n < count_; ++n)
        addNeighbour(neighbours_[static_cast<std::size_t>(n)], firstCell, cells, hulls);
    return cells;
}

glm::ivec3 BrickProof::rangesOf(const glm::ivec3& brick, CellHulls& hulls) {
    coarsest_ = levelOf(brick);
    findNeighbours(brick, coarsest_, false);
    for (int n = 0; n < count_; ++n)
        coarsest_ = std::max(coarsest_, neighbours_[static_cast<std::size_t>(n)].level);
    return rangesAmong(brick, hulls);
}

std::uint64_t BrickProof::cellsOf(const glm::ivec3& brick) {
    const std::size_t index = linearIndex(brick, in_.selection.bricks);
    if (!in_.statistics.hasLabels() && empty({wide_[index].x, wide_[index].y, kShowsFunction}))
        return 0; // at any levels
    const int level = levelOf(brick);
    findNeighbours(brick, level, false);
    Hull all = rangeOf(brick, level);
    for (int n = 0; n < count_; ++n) {
        const Neighbour& near = neighbours_[static_cast<std::size_t>(n)];
        if (near.level > 0 || near.layers.x > 1 || near.layers.y > 1 || near.layers.z > 1)
            all.add(rangeOf(near.brick, near.level));
        else
            all.add(voxelRange(index)); // its layer is within ours
    }
    if (empty(all))
        return 0;
    CellHulls hulls;
    const glm::ivec3 cells = rangesAmong(brick, hulls);
    std::uint64_t mask = 0;
    forEachCell(cells, [&](const glm::ivec3& at) {
        mask |= static_cast<std::uint64_t>(!empty(hulls[cellBit(at)])) << cellBit(at);
    });
    return mask;
}

std::uint64_t BrickProof::plainCellsOf(const glm::ivec3& brick) {
    if (levelOf(brick) != 0)
        return 0;
    findNeighbours(brick, 0, true);
    std::uint64_t plain = ~std::uint64_t{0};
    for (int i = 0; i < count_; ++i) {
        const Neighbour& n = neighbours_[static_cast<std::size_t>(i)];
        if (n.plain && (n.level == 0 || n.level == Selection::kEmpty))
            continue;
        forEachCell(glm::ivec3(kCellsPerBrick), [&](const glm::ivec3& at) {
            for (int axis = 0; axis < 3; ++axis) {
                const int layer = n.side[axis] > 0 ? kCellsPerBrick - 1 - at[axis] : at[axis];
                if (n.side[axis] != 0 && layer >= n.layers[axis])
                    return;
            }
            plain &= ~(std::uint64_t{1} << cellBit(at));
        });
    }
    return plain;
}

} // namespace tessera

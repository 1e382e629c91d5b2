// render/occupancy.cpp: see occupancy.h.
#include "render/occupancy.h"

#include "core/error.h"
#include "core/threads.h"
#include "render/brick_corner.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>

namespace tessera {
namespace {

constexpr std::size_t kBricksAtATime = 64; // per turn of a thread

struct Hull {
    float lo = std::numeric_limits<float>::infinity(), hi = -std::numeric_limits<float>::infinity();
    void add(float low, float high) {
        lo = std::min(lo, low);
        hi = std::max(hi, high);
    }
    void add(const Hull& other) { add(other.lo, other.hi); }
};

/// TransferTable::emptyOver() of stored values, without a call: it is asked for every cell.
class ZeroExtinction {
  public:
    ZeroExtinction(const TransferTable& table, const VolumeInfo& info)
        : nonZeroUpTo_(table.nonZeroUpTo.data()), last_(static_cast<double>(table.entries.size() - 1)) {
        const double perValue = static_cast<double>(table.entriesPerValue);
        scale_ = info.rescaleSlope * perValue;
        offset_ = (info.rescaleIntercept - static_cast<double>(table.firstValue)) * perValue;
    }
    bool over(const Hull& h) const {
        const double x = static_cast<double>(h.lo) * scale_ + offset_;
        const double y = static_cast<double>(h.hi) * scale_ + offset_;
        const double a = std::clamp(std::min(x, y), 0.0, last_ + 1),
                     b = std::clamp(std::max(x, y), -1.0, last_);
        const int first = std::max(static_cast<int>(a) - 1, 0); // floor - 1
        const int whole = static_cast<int>(b);
        const int final = std::min(whole + (whole < b ? 1 : 0) + 1, static_cast<int>(last_)); // ceil + 1
        return nonZeroUpTo_[final] == (first == 0 ? 0 : nonZeroUpTo_[first - 1]);
    }

  private:
    const int* nonZeroUpTo_;
    double last_, scale_ = 0, offset_ = 0;
};

std::size_t cellBit(const glm::ivec3& at) {
    return static_cast<std::size_t>(at.x + 4 * at.y + 16 * at.z);
}
template <typename Visit> void forEachCell(const glm::ivec3& cells, const Visit& visit) {
    glm::ivec3 at(0);
    for (at.z = 0; at.z < cells.z; ++at.z)
        for (at.y = 0; at.y < cells.y; ++at.y)
            for (at.x = 0; at.x < cells.x; ++at.x)
                visit(at);
}

/// Cells of a brick along one axis, both ends included.
struct Span {
    int first = 0, last = 0;
};

/// Cells that hold the samples that points of a cell can reach in a brick of this level, along one axis that
/// both share. Interpolation reaches one sample beyond the cell at levels whose samples are no larger than a
/// cell (at level 0 the cell's own range covers it); of the two samples of level 4, cells at the ends reach
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

/// One brick's cells against a function. Levels as bricks have them, statistics as they are stored.
class BrickProof {
  public:
    BrickProof(const OccupancyInput& input, const std::vector<glm::vec2>& wide, std::uint32_t finest)
        : in_(input), wide_(wide), finest_(finest), zero_(input.table, input.info) {}

    std::uint64_t cellsOf(const glm::ivec3& brick);
    /// Cells of a brick of level 0 that only level 0 and empty bricks reach, the way they meet at one level.
    std::uint64_t plainCellsOf(const glm::ivec3& brick);

  private:
    struct Neighbour {
        glm::ivec3 side{0}, brick{0};
        int level = 0;
        bool plain = true; // blends over half a sample of level 0
        float mean = 0;
        glm::ivec3 layers{0}; // of cells that it reaches into, per axis that is crossed
    };
    static bool isValue(int level) { return level + 1 >= kLevelCount; } // reads as its mean
    int levelOf(const glm::ivec3& brick) const {
        return in_.selection.levels[linearIndex(brick, in_.selection.bricks)];
    }
    Hull rangeOf(const glm::ivec3& brick, int level) const {
        const std::size_t b = linearIndex(brick, in_.selection.bricks);
        if (isValue(level))
            return {in_.selection.means[b], in_.selection.means[b]};
        return voxelRange(b);
    }
    /// Of a brick's voxels and one layer around them.
    Hull voxelRange(std::size_t brick) const {
        return {in_.statistics.brickMin[brick], in_.statistics.brickMax[brick]};
    }
    bool empty(const Hull& h) const { return zero_.over(h); }
    Hull cellRange(const glm::ivec3& cell) const {
        const std::size_t c = linearIndex(cell, in_.statistics.cells);
        return {in_.statistics.cellMin[c], in_.statistics.cellMax[c]};
    }
    Hull rangeOver(const glm::ivec3& firstCell, const Span& x, const Span& y, const Span& z) const;
    void findNeighbours(const glm::ivec3& brick, int level, bool everyOne);
    using CellHulls = std::array<Hull, 64>; // x + 4y + 16z
    /// Adds its samples to the hulls of the cells whose points can reach them.
    void addNeighbour(const Neighbour& n, const glm::ivec3& firstCell, const glm::ivec3& cells,
                      CellHulls& hulls) const;

    const OccupancyInput& in_;
    const std::vector<glm::vec2>& wide_;
    std::uint32_t finest_;
    ZeroExtinction zero_;
    std::array<Neighbour, 26> neighbours_;
    int count_ = 0;
};

Hull BrickProof::rangeOver(const glm::ivec3& firstCell, const Span& x, const Span& y, const Span& z) const {
    Hull hull;
    for (int k = z.first; k <= z.last; ++k)
        for (int j = y.first; j <= y.last; ++j)
            for (int i = x.first; i <= x.last; ++i)
                hull.add(cellRange(firstCell + glm::ivec3(i, j, k)));
    return hull;
}

/// Those whose weight is not zero everywhere in the brick, and whose samples the cells' own ranges do not
/// cover.
void BrickProof::findNeighbours(const glm::ivec3& brick, int level, bool everyOne) {
    count_ = 0;
    glm::ivec3 side(0);
    for (side.z = -1; side.z <= 1; ++side.z)
        for (side.y = -1; side.y <= 1; ++side.y)
            for (side.x = -1; side.x <= 1; ++side.x) {
                const glm::ivec3 at = brick + side;
                if (side == glm::ivec3(0) || glm::any(glm::lessThan(at, glm::ivec3(0))) ||
                    glm::any(glm::greaterThanEqual(at, in_.selection.bricks)))
                    continue;
                Neighbour n{side, at, levelOf(at), true, 0, glm::ivec3(0)};
                bool reaches = true, deep = false;
                for (int axis = 0; axis < 3; ++axis) {
                    if (side[axis] == 0)
                        continue;
                    glm::ivec3 facing = at;
                    facing[axis] -= side[axis];
                    const float reach = edgeReach<float>(static_cast<std::uint32_t>(n.level),
                                                         static_cast<std::uint32_t>(levelOf(facing)),
                                                         in_.edgeFunction, finest_)
                                            .other;
                    n.layers[axis] = static_cast<int>(std::ceil(reach / float{kCellExtent}));
                    reaches = reaches && n.layers[axis] > 0;
                    deep = deep || n.layers[axis] > 1;
                    n.plain = n.plain && reach == halfSample<float>(0);
                }
                if (everyOne) {
                    if (in_.edgeFunction == EdgeFunction::nearest)
                        n = {side, at, levelOf(at), false, 0, glm::ivec3(1)};
                } else if (!reaches || (level == 0 && n.level == 0 && !deep))
                    continue;
                if (isValue(n.level))
                    n.mean = in_.selection.means[linearIndex(at, in_.selection.bricks)];
                neighbours_[static_cast<std::size_t>(count_++)] = n;
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
                    hull.add(n.mean, n.mean);
                    continue;
                }
                std::array<Span, 3> spans = crossed;
                bool beside = true; // the cell touches the brick that is crossed into
                for (int axis = 0; axis < 3; ++axis)
                    if (n.side[axis] == 0)
                        spans[static_cast<std::size_t>(axis)] = reachedAlong(n.level, at[axis], cells[axis]);
                    else
                        beside = beside && at[axis] == (n.side[axis] > 0 ? cells[axis] - 1 : 0);
                Hull there = rangeOver(n.brick * kCellsPerBrick, spans[0], spans[1], spans[2]);
                if (n.level == 0 && beside) {
                    // One layer of voxels, which the range of the cell at hand covers too: both hulls hold
                    // it.
                    const Hull own = cellRange(firstCell + at);
                    there = {std::max(there.lo, own.lo), std::min(there.hi, own.hi)};
                }
                hull.add(there);
            }
}

std::uint64_t BrickProof::cellsOf(const glm::ivec3& brick) {
    const std::size_t index = linearIndex(brick, in_.selection.bricks);
    if (empty({wide_[index].x, wide_[index].y}))
        return 0; // whatever the levels
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
    const glm::ivec3 firstCell = brick * kCellsPerBrick;
    const glm::ivec3 cells = glm::min(glm::ivec3(kCellsPerBrick), in_.statistics.cells - firstCell);
    CellHulls hulls;
    forEachCell(cells, [&](const glm::ivec3& at) {
        Hull& hull = hulls[cellBit(at)];
        if (isValue(level))
            hull = rangeOf(brick, level);
        else if (level == 0)
            hull = cellRange(firstCell + at);
        else
            hull = rangeOver(firstCell, reachedAlong(level, at.x, cells.x),
                             reachedAlong(level, at.y, cells.y), reachedAlong(level, at.z, cells.z));
    });
    for (int n = 0; n < count_; ++n)
        addNeighbour(neighbours_[static_cast<std::size_t>(n)], firstCell, cells, hulls);
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

/// A brick and those that touch it.
void forEachAround(const glm::ivec3& at, const glm::ivec3& bricks, const auto& visit) {
    const glm::ivec3 low = glm::max(at - 1, glm::ivec3(0)), high = glm::min(at + 1, bricks - 1);
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x)
                visit(linearIndex({x, y, z}, bricks));
}

void forEachBrick(std::size_t count, int threads, const auto& visit) {
    parallelFor((count + kBricksAtATime - 1) / kBricksAtATime, threads, [&](std::size_t turn) {
        visit(turn * kBricksAtATime, std::min(count, (turn + 1) * kBricksAtATime));
    });
}

} // namespace

std::size_t Occupancy::bytes(const glm::ivec3& extentVoxels, MapScale scale) {
    const std::size_t brick = sizeof(glm::vec2) + sizeof(std::uint8_t) + 2 * sizeof(std::uint64_t);
    return mapBytes(extentVoxels, scale) + brick * cellCount(brickGrid(extentVoxels));
}

Occupancy::Occupancy(const OccupancyInput& input, MapScale scale, Ledger& ram, int threads)
    : scale_(scale), extentVoxels_(input.info.extentVoxels), grid_(mapGrid(extentVoxels_, scale)),
      bricks_(input.selection.bricks) {
    charge_ = ram.charge(bytes(extentVoxels_, scale), "the map of empty space");
    const std::size_t count = cellCount(bricks_);
    masks_.resize(count);
    plain_.resize(count);
    map_.resize(cellCount(grid_));
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    wide_.assign(count, {kInfinity, -kInfinity});
    const Statistics& statistics = input.statistics;
    forEachBrick(count, threads, [&](std::size_t first, std::size_t end) {
        for (std::size_t b = first; b < end; ++b)
            forEachAround(gridPosition(b, bricks_), bricks_, [&](std::size_t near) {
                wide_[b] = {std::min(wide_[b].x, statistics.brickMin[near]),
                            std::max(wide_[b].y, statistics.brickMax[near])};
            });
    });
    functionChanged(input, threads);
}

template <typename Which>
bool Occupancy::prove(const OccupancyInput& input, const Which& which, int threads) {
    TESSERA_CHECK(input.selection.bricks == bricks_);
    levels_ = input.selection.levels;
    finest_ = static_cast<std::uint32_t>(input.selection.finest());
    edgeFunction_ = input.edgeFunction;
    std::atomic<bool> changed = false;
    forEachBrick(masks_.size(), threads, [&](std::size_t first, std::size_t end) {
        BrickProof proof(input, wide_, finest_);
        bool mine = false;
        for (std::size_t b = first; b < end; ++b) {
            if (!which(b))
                continue;
            const std::uint64_t mask = proof.cellsOf(gridPosition(b, bricks_));
            const std::uint64_t plain = mask != 0 ? proof.plainCellsOf(gridPosition(b, bricks_)) : 0;
            mine = mine || mask != masks_[b] || plain != plain_[b];
            masks_[b] = mask;
            plain_[b] = plain;
        }
        if (mine)
            changed = true;
    });
    return changed;
}

bool Occupancy::functionChanged(const OccupancyInput& input, int threads) {
    const bool first = levels_.empty();
    if (!prove(
            input, [](std::size_t) { return true; }, threads) &&
        !first)
        return false;
    fillDistanceMap(extentVoxels_, masks_, scale_, map_, threads);
    return true;
}

bool Occupancy::levelsChanged(const OccupancyInput& input, int threads) {
    // Two empty bricks blend over the finest level's half sample, wherever they are.
    if (static_cast<std::uint32_t>(input.selection.finest()) != finest_ ||
        input.edgeFunction != edgeFunction_)
        return functionChanged(input, threads);
    std::vector<std::uint8_t> stale(masks_.size(), 0);
    for (std::size_t b = 0; b < stale.size(); ++b) {
        if (input.selection.levels[b] == levels_[b])
            continue;
        forEachAround(gridPosition(b, bricks_), bricks_, [&](std::size_t near) { stale[near] = 1; });
    }
    if (!prove(
            input, [&](std::size_t b) { return stale[b] != 0; }, threads))
        return false;
    fillDistanceMap(extentVoxels_, masks_, scale_, map_, threads);
    return true;
}

std::size_t Occupancy::occupiedCells() const {
    std::size_t count = 0;
    for (const std::uint64_t mask : masks_)
        count += static_cast<std::size_t>(std::popcount(mask));
    return count;
}

std::size_t Occupancy::plainCells() const {
    std::size_t count = 0;
    for (std::size_t b = 0; b < masks_.size(); ++b)
        count += static_cast<std::size_t>(std::popcount(masks_[b] & plain_[b]));
    return count;
}

namespace {
bool bitOf(const std::vector<std::uint64_t>& masks, const glm::ivec3& cell, const glm::ivec3& bricks) {
    return (masks[linearIndex(cell / kCellsPerBrick, bricks)] >> cellBit(cell % kCellsPerBrick) & 1u) != 0;
}
} // namespace

bool Occupancy::isEmpty(const glm::ivec3& cell) const {
    return !bitOf(masks_, cell, bricks_);
}

bool Occupancy::isPlain(const glm::ivec3& cell) const {
    return bitOf(plain_, cell, bricks_);
}

Occupancy Occupancy::plainChebyshev(Ledger& ram) const {
    Occupancy o;
    o.charge_ = ram.charge(mapBytes(extentVoxels_, scale_), "the map of empty space");
    o.scale_ = scale_;
    o.extentVoxels_ = extentVoxels_;
    o.grid_ = grid_;
    o.map_ = map_;
    for (SkippingTexel& texel : o.map_) {
        if (isOccupied(texel))
            continue;
        int least = kFarthest;
        for (int octant = 0; octant < 8; ++octant)
            least = std::min(least, octantDistance(texel, octant));
        texel = 0x0101010101010101u * static_cast<SkippingTexel>(least);
    }
    return o;
}

} // namespace tessera

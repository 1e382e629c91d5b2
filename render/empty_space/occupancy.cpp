// render/empty_space/occupancy.cpp: see occupancy.h.
#include "render/empty_space/occupancy.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <mutex>

namespace tessera {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostRanges = 256; // functions that users edit have few
constexpr double kReach = 3;             // entries: emptyOver() reads those less than two beyond its range

} // namespace

ShownRanges::ShownRanges(const TransferTable& table)
    : firstValue_(static_cast<double>(table.firstValue)),
      entriesPerValue_(static_cast<double>(table.entriesPerValue)), entries_(table.entries.size()) {
    const auto valueAt = [&](double entry) { return firstValue_ + entry / entriesPerValue_; };
    for (std::size_t i = 0; i < entries_ && !tooMany_; ++i) {
        if (!table.shows(i))
            continue;
        std::size_t end = i;
        while (end < entries_ && table.shows(end))
            ++end;
        shown_.push_back({i == 0 ? -kInfinity : valueAt(static_cast<double>(i) - 0.5),
                          end == entries_ ? kInfinity : valueAt(static_cast<double>(end) - 0.5)});
        tooMany_ = shown_.size() > kMostRanges;
        i = end;
    }
}

bool ShownRanges::shows(double value) const {
    return std::any_of(shown_.begin(), shown_.end(),
                       [&](const ValueRange& r) { return value > r.lowest && value < r.highest; });
}

std::vector<double> ShownRanges::ends() const {
    std::vector<double> ends;
    for (const ValueRange& r : shown_)
        for (const double end : {r.lowest, r.highest})
            if (std::isfinite(end))
                ends.push_back(end);
    return ends;
}

std::vector<ValueRange> ShownRanges::differences(const ShownRanges& other) const {
    if (tooMany_ || other.tooMany_ || entries_ == 0 || other.entries_ == 0)
        return {{-kInfinity, kInfinity}};
    std::vector<double> ends = this->ends();
    const std::vector<double> others = other.ends();
    ends.insert(ends.end(), others.begin(), others.end());
    std::sort(ends.begin(), ends.end());
    const double reach = kReach / std::min(entriesPerValue_, other.entriesPerValue_);
    std::vector<ValueRange> ranges;
    // Tables of different size round ranges differently: then also around every end of a visible range of
    // either.
    if (entries_ != other.entries_ || firstValue_ != other.firstValue_ ||
        entriesPerValue_ != other.entriesPerValue_)
        for (const double end : ends)
            ranges.push_back({end - reach, end + reach});
    for (std::size_t i = 0; i <= ends.size(); ++i) { // between one end and the next
        const double low = i == 0 ? -kInfinity : ends[i - 1], high = i == ends.size() ? kInfinity : ends[i];
        const double within = std::isfinite(low) ? (std::isfinite(high) ? 0.5 * (low + high) : low + 1)
                                                 : (std::isfinite(high) ? high - 1 : 0);
        if (low < high && shows(within) != other.shows(within))
            ranges.push_back({low - reach, high + reach});
    }
    return ranges;
}

namespace {

constexpr std::size_t kBricksAtATime = 64; // per task of a thread

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

Occupancy::Occupancy(const OccupancyInput& input, MapScale scale, MemoryBudget& ram, int threads)
    : scale_(scale), extentVoxels_(input.info.extentVoxels), grid_(mapGrid(extentVoxels_, scale)),
      bricks_(input.selection.bricks) {
    charge_ = ram.charge(bytes(extentVoxels_, scale), "the occupancy map");
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

bool Occupancy::functionChanged(const OccupancyInput& input, int threads) {
    return follow(input, true, threads);
}

bool Occupancy::levelsChanged(const OccupancyInput& input, int threads) {
    return follow(input, false, threads);
}

bool Occupancy::follow(const OccupancyInput& input, bool functionChanged, int threads) {
    TESSERA_CHECK(input.selection.bricks == bricks_);
    const bool first = levels_.empty();
    const std::vector<std::size_t> stale = staleBricks(input, functionChanged);
    levels_ = input.selection.levels;
    finest_ = static_cast<std::uint32_t>(input.selection.finest());
    edgeFunction_ = input.edgeFunction;
    if (functionChanged)
        shown_ = ShownRanges(input.table);
    const std::vector<std::size_t> changed = prove(input, stale, threads);
    ChangedSlices slices;
    if (first) {
        fillDistanceMap(extentVoxels_, masks_, scale_, map_, threads);
        slices = {0, grid_.z};
    } else {
        slices = updateDistanceMap(extentVoxels_, masks_, scale_, changed, map_, threads);
        const int perBrick = scale_ == MapScale::cells ? kCellsPerBrick : 1;
        for (const std::size_t brick : changed) { // also where only plain cells changed
            const int z = gridPosition(brick, bricks_).z * perBrick;
            slices.add({z, std::min(z + perBrick, grid_.z)});
        }
    }
    if (functionChanged) // blocks found by the device are no longer valid anywhere
        slices = {0, grid_.z};
    if (!slices.any())
        return false;
    ++version_;
    changed_ = slices;
    return !changed.empty() || first;
}

ChangedSlices Occupancy::changedSince(std::uint64_t version) const {
    if (version == version_)
        return {};
    return version + 1 == version_ ? changed_ : ChangedSlices{0, grid_.z};
}

/// All bricks whose result can change.
std::vector<std::size_t> Occupancy::staleBricks(const OccupancyInput& input, bool functionChanged) const {
    // Two empty bricks blend over the finest level's half sample, at any position.
    const bool all = levels_.empty() || static_cast<std::uint32_t>(input.selection.finest()) != finest_ ||
                     input.edgeFunction != edgeFunction_;
    std::vector<std::uint8_t> stale(masks_.size(), all ? 1 : 0);
    for (std::size_t b = 0; !all && b < stale.size(); ++b)
        if (input.selection.levels[b] != levels_[b])
            forEachAround(gridPosition(b, bricks_), bricks_, [&](std::size_t near) { stale[near] = 1; });
    if (!all && functionChanged) {
        const std::vector<ValueRange> ranges = ShownRanges(input.table).differences(shown_);
        for (std::size_t b = 0; b < stale.size() && !ranges.empty(); ++b) {
            const double x =
                input.info.rescaleSlope * static_cast<double>(wide_[b].x) + input.info.rescaleIntercept;
            const double y =
                input.info.rescaleSlope * static_cast<double>(wide_[b].y) + input.info.rescaleIntercept;
            const ValueRange wide{std::min(x, y), std::max(x, y)};
            for (const ValueRange& range : ranges)
                stale[b] = stale[b] != 0 || wide.meets(range) ? 1 : 0;
        }
    }
    std::vector<std::size_t> bricks;
    for (std::size_t b = 0; b < stale.size(); ++b)
        if (stale[b] != 0)
            bricks.push_back(b);
    return bricks;
}

/// Returns the bricks that changed.
std::vector<std::size_t> Occupancy::prove(const OccupancyInput& input, const std::vector<std::size_t>& bricks,
                                          int threads) {
    std::vector<std::size_t> changed;
    std::mutex mutex;
    forEachBrick(bricks.size(), threads, [&](std::size_t first, std::size_t end) {
        BrickProof proof(input, wide_, finest_);
        std::vector<std::size_t> mine;
        for (std::size_t i = first; i < end; ++i) {
            const std::size_t b = bricks[i];
            const std::uint64_t mask = proof.cellsOf(gridPosition(b, bricks_));
            const std::uint64_t plain = mask != 0 ? proof.plainCellsOf(gridPosition(b, bricks_)) : 0;
            if (mask != masks_[b] || plain != plain_[b])
                mine.push_back(b);
            masks_[b] = mask;
            plain_[b] = plain;
        }
        const std::lock_guard lock(mutex);
        changed.insert(changed.end(), mine.begin(), mine.end());
    });
    return changed;
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

Occupancy Occupancy::plainChebyshev(MemoryBudget& ram) const {
    Occupancy o;
    o.charge_ = ram.charge(mapBytes(extentVoxels_, scale_), "the occupancy map");
    o.scale_ = scale_;
    o.extentVoxels_ = extentVoxels_;
    o.grid_ = grid_;
    o.map_ = map_;
    o.version_ = 1;
    o.changed_ = {0, grid_.z};
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

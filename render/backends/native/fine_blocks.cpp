// render/backends/native/fine_blocks.cpp: see fine_blocks.h.
#include "render/backends/native/fine_blocks.h"

#include "core/base/error.h"
#include "render/backends/native/block_ranges.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {
namespace {

/// Entries of the table around a range of places, and those of them that show something.
struct Entries {
    int showing = 0, all = 0;
};
Entries entriesWithin(const TransferTable& table, float low, float high) {
    const float end = static_cast<float>(table.entries.size() - 1);
    const float first = std::clamp(low, 0.0f, end), last = std::clamp(high, 0.0f, end);
    const auto from = static_cast<std::size_t>(static_cast<int>(first)); // not negative, so this is floor
    const int whole = static_cast<int>(last);
    const auto to = static_cast<std::size_t>(whole + (static_cast<float>(whole) < last ? 1 : 0));
    return {table.nonZeroUpTo[to] - (from == 0 ? 0 : table.nonZeroUpTo[from - 1]),
            static_cast<int>(to - from) + 1};
}

/// True if any value of the range shows. Entry i shows from i - 1 to i + 1, because entries are interpolated
/// between.
bool showsWithin(const TransferTable& table, float low, float high) {
    const Entries e = entriesWithin(table, low, high);
    return e.showing > 0;
}
/// True if every value of the range shows.
bool showsThroughout(const TransferTable& table, float low, float high) {
    const Entries e = entriesWithin(table, low, high);
    return e.showing == e.all;
}

/// All of whose blocks show.
constexpr SkippingTexel kAllShow = ~SkippingTexel{0};
/// Of a cell that is empty after all, and no further.
constexpr SkippingTexel kEmptyAlone = 0x0101010101010101u;

} // namespace

double raysPerCell(const RayFrame<double>& frame) {
    const double plane = 4 * glm::length(glm::cross(frame.right, frame.up)); // voxels squared
    return frame.imageSize.x * frame.imageSize.y * kCellExtent * kCellExtent / plane;
}

bool FineBlocks::pay(bool mixed, double raysPerCell) {
    // Testing a cell takes as long as this number of rays takes through its empty part
    // (docs/measurements/performance.md). Where levels mix, cells are blended from several bricks.
    constexpr double kRays = 8, kMixedRays = 16;
    return raysPerCell >= (mixed ? kMixedRays : kRays);
}

FineBlocks::FineBlocks(const FineBlocksInput& input, MemoryBudget& gpu)
    : in_(input), charge_(gpu.charge(bytes(input.occupancy), "blocks of empty space")),
      map_(input.occupancy.map()) {
    TESSERA_CHECK(in_.occupancy.scale() == MapScale::cells && in_.statistics.cellMin.size() == map_.size());
    for (SkippingTexel& texel : map_)
        if (isOccupied(texel))
            texel = 0;
}

native::PacketEmptySpace FineBlocks::space() const {
    native::PacketEmptySpace space;
    space.map = map_.data();
    for (int axis = 0; axis < 3; ++axis)
        space.grid[axis] = in_.occupancy.grid()[axis];
    space.shift = boxShift(MapScale::cells);
    space.finer = this;
    space.look = [](const void* finer, std::int32_t cell) {
        static_cast<const FineBlocks*>(finer)->look(cell);
    };
    return space;
}

/// @param cell  [z][y][x]
void FineBlocks::look(std::int32_t cell) const {
    const auto number = static_cast<std::size_t>(cell);
    std::atomic_ref<SkippingTexel> texel(map_[number]);
    if (texel.load(std::memory_order_relaxed) != 0)
        return; // for another lane's ray, or another thread's
    const auto publish = [&texel](SkippingTexel found) {
        SkippingTexel nothing = 0;
        return texel.compare_exchange_strong(nothing, found, std::memory_order_relaxed);
    };
    const Optics& optics = in_.optics;
    const float a = in_.statistics.cellMin[number] * optics.scale + optics.offset;
    const float b = in_.statistics.cellMax[number] * optics.scale + optics.offset;
    if (showsThroughout(in_.table, std::min(a, b), std::max(a, b))) {
        publish(kAllShow);
        return;
    }
    BlockRanges field(in_.plane, in_.levels, in_.level, optics.scale, optics.offset, in_.target);
    const glm::ivec3& grid = in_.occupancy.grid();
    const native::CellRanges& ranges =
        field.of({cell % grid.x, cell / grid.x % grid.y, cell / grid.x / grid.y});
    // The largest error of a computed value between samples: some sixty roundings of 2^-24, here and where
    // rays take it and blend it.
    const float slack =
        (std::max(std::abs(ranges.low), std::abs(ranges.high)) + 2 * std::abs(optics.offset)) / 131072.0f;
    std::uint64_t blocks = 0;
    for (int n = 0; n < 64; ++n)
        if (showsWithin(in_.table, ranges.blockLow[n] - slack, ranges.blockHigh[n] + slack))
            blocks |= std::uint64_t{1} << n;
    // Of two threads that found the same, one counts.
    if (publish(blocks != 0 ? occupiedTexel(blocks) : kEmptyAlone))
        looked_.fetch_add(1, std::memory_order_relaxed);
}

} // namespace tessera

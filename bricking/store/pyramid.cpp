// bricking/store/pyramid.cpp: see pyramid.h.
#include "bricking/store/pyramid.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

template <typename Value> struct Mean {
    using Sum = std::int32_t;
    static Value of(Sum sum) {
        const Sum floor = sum >> 3, rest = sum & 7; // arithmetic shift: floor for negative sums too
        return static_cast<Value>(floor + (rest > 4 || (rest == 4 && (floor & 1)) ? 1 : 0));
    }
};
template <> struct Mean<float> {
    using Sum = double;
    static float of(Sum sum) { return static_cast<float>(sum * 0.125); }
};

template <typename Value> void reduceSlice(const glm::ivec3& extent, const Value* in, Value* out, int z) {
    using Sum = typename Mean<Value>::Sum;
    const glm::ivec3 half = ceilDiv(extent, 2);
    const auto row = [&](int y, int slice) {
        return in + linearIndex({0, std::min(y, extent.y - 1), std::min(slice, extent.z - 1)}, extent);
    };
    for (int y = 0; y < half.y; ++y) {
        const Value* const r00 = row(2 * y, 2 * z);
        const Value* const r01 = row(2 * y + 1, 2 * z);
        const Value* const r10 = row(2 * y, 2 * z + 1);
        const Value* const r11 = row(2 * y + 1, 2 * z + 1);
        Value* const to = out + linearIndex({0, y, z}, half);
        const auto meanOf = [&](int a, int b) {
            return Mean<Value>::of(static_cast<Sum>(r00[a]) + static_cast<Sum>(r00[b]) +
                                   static_cast<Sum>(r01[a]) + static_cast<Sum>(r01[b]) +
                                   static_cast<Sum>(r10[a]) + static_cast<Sum>(r10[b]) +
                                   static_cast<Sum>(r11[a]) + static_cast<Sum>(r11[b]));
        };
        const int whole = extent.x / 2;
        for (int x = 0; x < whole; ++x)
            to[x] = meanOf(2 * x, 2 * x + 1);
        if (whole < half.x)
            to[whole] = meanOf(2 * whole, 2 * whole);
    }
}

template <typename Value>
void reduce(const glm::ivec3& extent, std::span<const std::byte> in, std::span<std::byte> out, int threads) {
    const glm::ivec3 half = ceilDiv(extent, 2);
    TESSERA_CHECK(in.size() == cellCount(extent) * sizeof(Value));
    TESSERA_CHECK(out.size() == cellCount(half) * sizeof(Value));
    const auto* from = reinterpret_cast<const Value*>(in.data());
    auto* to = reinterpret_cast<Value*>(out.data());
    parallelFor(static_cast<std::size_t>(half.z), threads,
                [&](std::size_t z) { reduceSlice(extent, from, to, static_cast<int>(z)); });
}

} // namespace

void reduceByTwo(ValueType type, const glm::ivec3& extent, std::span<const std::byte> in,
                 std::span<std::byte> out, int threads) {
    switch (type) {
    case ValueType::u8:
        return reduce<std::uint8_t>(extent, in, out, threads);
    case ValueType::i16:
        return reduce<std::int16_t>(extent, in, out, threads);
    case ValueType::u16:
        return reduce<std::uint16_t>(extent, in, out, threads);
    case ValueType::f32:
        return reduce<float>(extent, in, out, threads);
    }
}

SlabPyramid::SlabPyramid(const glm::ivec3& extentVoxels, ValueType type, MemoryBudget& ram, int threads,
                         Sink sink, PyramidRule rule)
    : type_(type), threads_(threads), sink_(std::move(sink)), rule_(std::move(rule)),
      charge_(ram.charge(bytesNeeded(extentVoxels, type), "one slab of 32 slices of every level")) {
    if (!rule_.reduce)
        rule_.reduce = reduceByTwo;
    for (int l = 0; l < kLevelCount; ++l) {
        Level& level = levels_[static_cast<std::size_t>(l)];
        level.extent = levelExtent(extentVoxels, l);
        level.values.resize(sliceBytes(level) *
                            static_cast<std::size_t>(std::min(kChunkExtent, level.extent.z)));
    }
}

std::size_t SlabPyramid::bytesNeeded(const glm::ivec3& extentVoxels, ValueType type) {
    std::size_t bytes = 0;
    for (int l = 0; l < kLevelCount; ++l) {
        glm::ivec3 slab = levelExtent(extentVoxels, l);
        slab.z = std::min(slab.z, kChunkExtent);
        bytes += cellCount(slab) * bytesPerValue(type);
    }
    return bytes;
}

std::size_t SlabPyramid::sliceBytes(const Level& level) const {
    return cellCount({level.extent.x, level.extent.y, 1}) * bytesPerValue(type_);
}

int SlabPyramid::nextSlices() const {
    return std::min(kChunkExtent, levels_[0].extent.z - levels_[0].firstSlice);
}

std::span<std::byte> SlabPyramid::next() {
    return std::span(levels_[0].values)
        .first(sliceBytes(levels_[0]) * static_cast<std::size_t>(nextSlices()));
}

void SlabPyramid::swapNext(std::vector<std::byte>& slab) {
    TESSERA_CHECK(slab.size() == levels_[0].values.size());
    slab.swap(levels_[0].values);
}

void SlabPyramid::push() {
    TESSERA_CHECK(nextSlices() > 0);
    levels_[0].filled = nextSlices();
    complete(0);
}

void SlabPyramid::complete(int l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    const auto values = std::span(std::as_const(level.values))
                            .first(sliceBytes(level) * static_cast<std::size_t>(level.filled));
    sink_({l, level.firstSlice, level.filled, values});
    if (l + 1 < kLevelCount) {
        Level& coarser = levels_[static_cast<std::size_t>(l) + 1];
        const int slices = (level.filled + 1) / 2;
        const auto out = std::span(coarser.values)
                             .subspan(sliceBytes(coarser) * static_cast<std::size_t>(coarser.filled),
                                      sliceBytes(coarser) * static_cast<std::size_t>(slices));
        rule_.reduce(type_, {level.extent.x, level.extent.y, level.filled}, values, out, threads_);
        coarser.filled += slices;
        if (coarser.filled == std::min(kChunkExtent, coarser.extent.z - coarser.firstSlice))
            complete(l + 1);
    }
    level.firstSlice += level.filled;
    level.filled = 0;
}

} // namespace tessera

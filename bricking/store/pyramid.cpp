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

namespace {

/// Of a level: a slab has at most kChunkExtent slices.
glm::ivec3 slabExtent(const glm::ivec3& extentVoxels, int level) {
    glm::ivec3 slab = levelExtent(extentVoxels, level);
    slab.z = std::min(slab.z, kChunkExtent);
    return slab;
}

/// Rows of a slab that lies in a file, as many as a band of level 0 has room for.
int bandRowsOf(const glm::ivec3& extentVoxels, int level, const SlabPlan& plan) {
    const glm::ivec3 finest = slabExtent(extentVoxels, 0), slab = slabExtent(extentVoxels, level);
    if (level >= plan.firstHeld && level > 0)
        return slab.y;
    const std::size_t room =
        cellCount({finest.x, std::min(plan.bandRows, finest.y), finest.z}) / cellCount({slab.x, 1, slab.z});
    const auto all = static_cast<std::size_t>(slab.y);
    return static_cast<int>(
        room >= all ? all : std::min(all, std::max<std::size_t>(room / kChunkExtent, 1) * kChunkExtent));
}

/// Of the band of a slab of `level` in a file that takes the most room.
std::size_t bandBytes(const glm::ivec3& extentVoxels, ValueType type, const SlabPlan& plan, int level) {
    const glm::ivec3 slab = slabExtent(extentVoxels, level);
    return cellCount({slab.x, bandRowsOf(extentVoxels, level, plan), slab.z}) * bytesPerValue(type);
}

/// Of what bands become that lie in files.
std::size_t reducedBytes(const glm::ivec3& extentVoxels, ValueType type, const SlabPlan& plan) {
    std::size_t most = 0;
    for (int level = 0; level + 1 < std::min(plan.firstHeld, kLevelCount); ++level) {
        const glm::ivec3 slab = slabExtent(extentVoxels, level);
        const glm::ivec3 half = ceilDiv({slab.x, bandRowsOf(extentVoxels, level, plan), slab.z}, 2);
        most = std::max(most, cellCount(half) * bytesPerValue(type));
    }
    return most;
}

} // namespace

SlabPyramid::SlabPyramid(const glm::ivec3& extentVoxels, ValueType type, MemoryBudget& ram, int threads,
                         Sink sink, PyramidRule rule, const SlabPlan& plan)
    : type_(type), threads_(threads), sink_(std::move(sink)), rule_(std::move(rule)),
      charge_(ram.charge(bytesNeeded(extentVoxels, type, plan), plan.isWhole()
                                                                    ? "one slab of 32 slices of every level"
                                                                    : "bands of slabs of 32 slices")) {
    TESSERA_CHECK(plan.bandRows >= extentVoxels.y || plan.bandRows % kChunkExtent == 0);
    if (!rule_.reduce)
        rule_.reduce = reduceByTwo;
    if (const std::uint64_t bytes = fileBytes(extentVoxels, type, plan); bytes > 0)
        requireDiskRoom(plan.folder, bytes, "slabs that have no room in memory");
    std::size_t finest = 0;
    for (int l = 0; l < kLevelCount; ++l) {
        Level& level = levels_[static_cast<std::size_t>(l)];
        level.extent = levelExtent(extentVoxels, l);
        level.bandRows = bandRowsOf(extentVoxels, l, plan);
        if (l == 0 || l < plan.firstHeld)
            finest = std::max(finest, bandBytes(extentVoxels, type, plan, l));
        if (l > 0 && l < plan.firstHeld)
            level.file.emplace(plan.folder);
        else if (l > 0)
            level.values.resize(sliceBytes(level) *
                                static_cast<std::size_t>(std::min(kChunkExtent, level.extent.z)));
    }
    levels_[0].values.resize(finest); // the bands of all files go through it
    reduced_.resize(reducedBytes(extentVoxels, type, plan));
}

std::size_t SlabPyramid::bytesNeeded(const glm::ivec3& extentVoxels, ValueType type, const SlabPlan& plan) {
    std::size_t bytes = reducedBytes(extentVoxels, type, plan), band = 0;
    for (int l = 0; l < kLevelCount; ++l)
        if (l == 0 || l < plan.firstHeld)
            band = std::max(band, bandBytes(extentVoxels, type, plan, l));
        else
            bytes += cellCount(slabExtent(extentVoxels, l)) * bytesPerValue(type);
    return bytes + band;
}

std::uint64_t SlabPyramid::fileBytes(const glm::ivec3& extentVoxels, ValueType type, const SlabPlan& plan) {
    std::uint64_t bytes = 0;
    for (int l = 1; l < std::min(plan.firstHeld, kLevelCount); ++l)
        bytes += cellCount(slabExtent(extentVoxels, l)) * bytesPerValue(type);
    return bytes;
}

std::size_t SlabPyramid::rowBytes(const Level& level) const {
    return static_cast<std::size_t>(level.extent.x) * bytesPerValue(type_);
}

std::size_t SlabPyramid::sliceBytes(const Level& level) const {
    return static_cast<std::size_t>(level.extent.y) * rowBytes(level);
}

int SlabPyramid::nextSlices() const {
    return std::min(kChunkExtent, levels_[0].extent.z - levels_[0].firstSlice);
}

int SlabPyramid::nextRows() const {
    return std::min(levels_[0].bandRows, levels_[0].extent.y - row_);
}

std::span<std::byte> SlabPyramid::next() {
    return std::span(levels_[0].values)
        .first(rowBytes(levels_[0]) * static_cast<std::size_t>(nextRows()) *
               static_cast<std::size_t>(nextSlices()));
}

void SlabPyramid::swapNext(std::vector<std::byte>& slab) {
    TESSERA_CHECK(slab.size() == levels_[0].values.size());
    slab.swap(levels_[0].values);
}

void SlabPyramid::push() {
    TESSERA_CHECK(nextSlices() > 0);
    levels_[0].filled = nextSlices();
    const int rows = nextRows();
    takeBand(0, row_, rows, next());
    row_ += rows;
    if (row_ == levels_[0].extent.y) {
        row_ = 0;
        end(0);
    }
}

/// Of the slab that is complete.
void SlabPyramid::takeBand(int l, int firstRow, int rows, std::span<const std::byte> values) {
    const Level& level = levels_[static_cast<std::size_t>(l)];
    sink_({l, level.firstSlice, level.filled, firstRow, rows, values});
    if (l + 1 < kLevelCount)
        reduceBand(level, levels_[static_cast<std::size_t>(l) + 1], firstRow, rows, values);
}

void SlabPyramid::reduceBand(const Level& level, Level& coarser, int firstRow, int rows,
                             std::span<const std::byte> values) {
    const auto slices = static_cast<std::size_t>((level.filled + 1) / 2);
    const std::size_t bytes = rowBytes(coarser) * static_cast<std::size_t>((rows + 1) / 2); // of a slice
    const auto placeOf = [&](std::size_t slice) {
        return sliceBytes(coarser) * (static_cast<std::size_t>(coarser.filled) + slice) +
               rowBytes(coarser) * static_cast<std::size_t>(firstRow / 2);
    };
    const glm::ivec3 extent(level.extent.x, rows, level.filled);
    if (coarser.file) {
        const auto out = std::span(reduced_).first(slices * bytes);
        rule_.reduce(type_, extent, values, out, threads_);
        for (std::size_t slice = 0; slice < slices; ++slice)
            coarser.file->write(placeOf(slice), out.subspan(slice * bytes, bytes));
    } else if (rows == level.extent.y) {
        rule_.reduce(type_, extent, values, std::span(coarser.values).subspan(placeOf(0), slices * bytes),
                     threads_);
    } else {
        const std::size_t from = rowBytes(level) * static_cast<std::size_t>(rows); // of a slice
        parallelFor(slices, threads_, [&](std::size_t slice) {
            const int pair = std::min(2, level.filled - 2 * static_cast<int>(slice));
            rule_.reduce(type_, {level.extent.x, rows, pair},
                         values.subspan(2 * slice * from, static_cast<std::size_t>(pair) * from),
                         std::span(coarser.values).subspan(placeOf(slice), bytes), 1);
        });
    }
}

void SlabPyramid::readBand(const Level& level, int firstRow, int rows, std::span<std::byte> out) const {
    const std::size_t bytes = rowBytes(level) * static_cast<std::size_t>(rows);
    for (int slice = 0; slice < level.filled; ++slice)
        level.file->read(sliceBytes(level) * static_cast<std::size_t>(slice) +
                             rowBytes(level) * static_cast<std::size_t>(firstRow),
                         out.subspan(static_cast<std::size_t>(slice) * bytes, bytes));
}

/// A slab of a level behind the first one.
void SlabPyramid::complete(int l) {
    const Level& level = levels_[static_cast<std::size_t>(l)];
    for (int row = 0; row < level.extent.y; row += level.bandRows) {
        const int rows = std::min(level.bandRows, level.extent.y - row);
        const std::span<std::byte> values =
            std::span(level.file ? levels_[0].values : levels_[static_cast<std::size_t>(l)].values)
                .first(rowBytes(level) * static_cast<std::size_t>(rows) *
                       static_cast<std::size_t>(level.filled));
        if (level.file)
            readBand(level, row, rows, values);
        takeBand(l, row, rows, values);
    }
    end(l);
}

/// Of a slab.
void SlabPyramid::end(int l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    const int slices = (level.filled + 1) / 2;
    level.firstSlice += level.filled;
    level.filled = 0;
    if (l + 1 == kLevelCount)
        return;
    Level& coarser = levels_[static_cast<std::size_t>(l) + 1];
    coarser.filled += slices;
    if (coarser.filled == std::min(kChunkExtent, coarser.extent.z - coarser.firstSlice))
        complete(l + 1);
}

} // namespace tessera

// bricking/statistics/statistics_pass.cpp: see statistics_pass.h.
#include "bricking/statistics/statistics_pass.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <limits>
#include <mutex>
#include <span>

namespace tessera {
namespace {

// The boxes of `extent` voxels that voxels of one chunk affect along an axis. These are its own, and by their
// ghost layer the last box of the chunk before (slot 0) and the first of the next chunk (the last slot).
template <int extent, int ghost> struct Slots {
    static constexpr int kCount = kChunkExtent / extent + 2;
    struct Range {
        int first, last; // voxels of the chunk, inclusive; empty when first > last
    };
    static Range range(int slot, int valid) {
        const int start = (slot - 1) * extent;
        return {std::max(start - ghost, 0), std::min(start + extent + ghost - 1, valid - 1)};
    }
};
using CellSlots = Slots<kCellExtent, 1>;
using WideSlots = Slots<kBrickExtent, 2>; // bricks with two layers around

template <typename Value, typename Slots> struct Boxes {
    Value lo[Slots::kCount][Slots::kCount][Slots::kCount],
        hi[Slots::kCount][Slots::kCount][Slots::kCount]; // [z][y][x]
};

/// True if a whole chunk has one value, to the bit.
template <typename Value> bool isOneValue(const Value* chunk, const glm::ivec3& valid) {
    constexpr std::size_t kVoxels = std::size_t{kChunkExtent} * kChunkExtent * kChunkExtent;
    const auto bytes = std::as_bytes(std::span(chunk, kVoxels));
    return valid == glm::ivec3(kChunkExtent) &&
           std::memcmp(bytes.data(), bytes.data() + sizeof(Value), bytes.size() - sizeof(Value)) == 0;
}
template <typename Value, typename Slots> void fillBoxes(Boxes<Value, Slots>& box, Value value) {
    for (auto* const ranges : {&box.lo, &box.hi})
        for (auto& plane : *ranges)
            for (auto& row : plane)
                std::fill(std::begin(row), std::end(row), value);
}

/// Minima and maxima axis by axis, y first and z next, because whole rows of x are vectorised.
/// @param valid  voxels inside the volume; rows are kChunkExtent long all the same
template <typename Value, typename Slots>
void boxOf(const Value* chunk, const glm::ivec3& valid, Boxes<Value, Slots>& box) {
    constexpr int kSlots = Slots::kCount;
    using Row = std::array<Value, kChunkExtent>;
    static thread_local std::array<std::array<Row, kSlots>, kChunkExtent> loY,
        hiY; // 48 KiB: not for the stack
    // Values, not references as of std::min(): only so compilers vectorise them.
    const auto fold = [](Row& lows, Row& highs, const Value* l, const Value* h) {
        Value* const __restrict lo = lows.data();
        Value* const __restrict hi = highs.data();
        for (std::size_t x = 0; x < kChunkExtent; ++x) {
            const Value low = lo[x], high = hi[x], less = l[x], more = h[x];
            lo[x] = less < low ? less : low;
            hi[x] = high < more ? more : high;
        }
    };
    const auto start = [](Row& lo, Row& hi) {
        lo.fill(std::numeric_limits<Value>::max());
        hi.fill(std::numeric_limits<Value>::lowest());
    };
    for (int z = 0; z < valid.z; ++z)
        for (int sy = 0; sy < kSlots; ++sy) {
            Row &lo = loY[static_cast<std::size_t>(z)][static_cast<std::size_t>(sy)],
                &hi = hiY[static_cast<std::size_t>(z)][static_cast<std::size_t>(sy)];
            start(lo, hi);
            const auto range = Slots::range(sy, valid.y);
            for (int y = range.first; y <= range.last; ++y) {
                const Value* row = chunk + linearIndex({0, y, z}, glm::ivec3(kChunkExtent));
                fold(lo, hi, row, row);
            }
        }
    for (int sz = 0; sz < kSlots; ++sz)
        for (int sy = 0; sy < kSlots; ++sy) {
            Row lo, hi;
            start(lo, hi);
            const auto rangeZ = Slots::range(sz, valid.z);
            for (int z = rangeZ.first; z <= rangeZ.last; ++z)
                fold(lo, hi, loY[static_cast<std::size_t>(z)][static_cast<std::size_t>(sy)].data(),
                     hiY[static_cast<std::size_t>(z)][static_cast<std::size_t>(sy)].data());
            for (int sx = 0; sx < kSlots; ++sx) {
                Value low = std::numeric_limits<Value>::max(), high = std::numeric_limits<Value>::lowest();
                const auto rangeX = Slots::range(sx, valid.x);
                for (int x = rangeX.first; x <= rangeX.last; ++x) {
                    low = std::min(low, lo[static_cast<std::size_t>(x)]);
                    high = std::max(high, hi[static_cast<std::size_t>(x)]);
                }
                box.lo[sz][sy][sx] = low;
                box.hi[sz][sy][sx] = high;
            }
        }
}

/// Merges the ranges of a chunk's boxes into those of the volume's.
template <typename Value, typename Slots>
void merge(const Boxes<Value, Slots>& box, const glm::ivec3& firstSlot, const RangeWindow& window) {
    for (int z = 0; z < Slots::kCount; ++z)
        for (int y = 0; y < Slots::kCount; ++y)
            for (int x = 0; x < Slots::kCount; ++x) {
                const glm::ivec3 place = firstSlot + glm::ivec3(x, y, z) - window.first;
                if (box.lo[z][y][x] > box.hi[z][y][x])
                    continue; // no voxel
                if (glm::any(glm::lessThan(place, glm::ivec3(0))) ||
                    glm::any(glm::greaterThanEqual(place, window.extent)))
                    continue;
                const std::size_t at = linearIndex(place, window.extent);
                window.least[at] = std::min(window.least[at], static_cast<float>(box.lo[z][y][x]));
                window.most[at] = std::max(window.most[at], static_cast<float>(box.hi[z][y][x]));
            }
}

/// @param range  of the whole volume
template <typename Value>
void mergeChunk(const glm::ivec3& chunk, const glm::ivec3& valid, std::span<const std::byte> bytes,
                const RangeWindow& ofCells, const RangeWindow& ofBricks, FoundRange& range,
                std::mutex& mutex) {
    const auto* values = reinterpret_cast<const Value*>(bytes.data());
    Boxes<Value, CellSlots> cells;
    Boxes<Value, WideSlots> wide;
    if (isOneValue(values, valid)) {
        fillBoxes(cells, values[0]);
        fillBoxes(wide, values[0]);
    } else {
        boxOf(values, valid, cells);
        boxOf(values, valid, wide);
    }
    const std::lock_guard lock(mutex);
    merge(cells, chunk * kCellsPerBrick - 1, ofCells);
    merge(wide, chunk - 1, ofBricks);
    if (wide.lo[1][1][1] <= wide.hi[1][1][1]) { // the chunk itself
        range.lowest = std::min(range.lowest, static_cast<float>(wide.lo[1][1][1]));
        range.highest = std::max(range.highest, static_cast<float>(wide.hi[1][1][1]));
    }
}

/// Value to bin; by table if there are few values, because the division is slow.
template <typename Value> class Binner {
  public:
    Binner(double lowest, double highest) : lowest_(lowest), highest_(highest) {
        if constexpr (sizeof(Value) <= 2)
            for (int value = kFirst; value <= std::numeric_limits<Value>::max(); ++value)
                table_.push_back(static_cast<std::uint8_t>(histogramBin(value, lowest, highest)));
    }
    std::size_t operator()(Value value) const {
        if constexpr (sizeof(Value) <= 2)
            return table_[static_cast<std::size_t>(static_cast<int>(value) - kFirst)];
        else
            return static_cast<std::size_t>(histogramBin(static_cast<double>(value), lowest_, highest_));
    }

  private:
    static constexpr int kFirst =
        sizeof(Value) <= 2 ? static_cast<int>(std::numeric_limits<Value>::lowest()) : 0;
    double lowest_, highest_;
    std::vector<std::uint8_t> table_;
};

} // namespace

void gatherCells(const StoreReader& store, Statistics& statistics, BufferPool& pool, int threads) {
    const VolumeInfo& info = store.info();
    static_assert(kBrickExtent == kChunkExtent, "a chunk of level 0 is a brick");
    const RangeWindow cells{glm::ivec3(0), statistics.cells, statistics.cellMin, statistics.cellMax};
    const RangeWindow wide{glm::ivec3(0), statistics.bricks, statistics.wideMin, statistics.wideMax};
    clearRanges(cells);
    clearRanges(wide);
    FoundRange range;
    const glm::ivec3 grid = chunkGrid(info.extentVoxels, 0);
    std::mutex mutex;
    parallelFor(cellCount(grid), threads, [&](std::size_t n) {
        const glm::ivec3 chunk = gridPosition(n, grid);
        const BufferPool::Lease buffer(pool);
        store.readChunk({0, chunk.x, chunk.y, chunk.z}, buffer.bytes());
        const glm::ivec3 valid = glm::min(info.extentVoxels - chunk * kChunkExtent, glm::ivec3(kChunkExtent));
        withValueType(info.type, [&](auto value) {
            mergeChunk<decltype(value)>(chunk, valid, buffer.bytes(), cells, wide, range, mutex);
        });
    });
    statistics.lowest = range.lowest;
    statistics.highest = range.highest;
}

void gatherMeans(const ChunkSource& volume, Statistics& statistics, BufferPool& pool) {
    constexpr int level = kLevelCount - 1;
    static_assert(kBrickExtent >> level == 1, "a sample of the coarsest level is a brick");
    const glm::ivec3 grid = chunkGrid(volume.info().extentVoxels, level);
    std::vector<ChunkKey> keys;
    for (std::size_t chunk = 0; chunk < cellCount(grid); ++chunk) {
        const glm::ivec3 at = gridPosition(chunk, grid);
        keys.push_back({level, at.x, at.y, at.z});
    }
    volume.willRead(keys);
    const BufferPool::Lease buffer(pool);
    for (int k = 0; k < grid.z; ++k)
        for (int j = 0; j < grid.y; ++j)
            for (int i = 0; i < grid.x; ++i) {
                volume.readChunk({level, i, j, k}, buffer.bytes());
                const glm::ivec3 first = glm::ivec3(i, j, k) * kChunkExtent;
                const glm::ivec3 size = glm::min(statistics.bricks - first, glm::ivec3(kChunkExtent));
                withValueType(volume.info().type, [&](auto value) {
                    const auto* values = reinterpret_cast<const decltype(value)*>(buffer.bytes().data());
                    for (int z = 0; z < size.z; ++z)
                        for (int y = 0; y < size.y; ++y)
                            for (int x = 0; x < size.x; ++x)
                                statistics
                                    .brickMean[linearIndex(first + glm::ivec3(x, y, z), statistics.bricks)] =
                                    static_cast<float>(
                                        values[linearIndex({x, y, z}, glm::ivec3(kChunkExtent))]);
                });
            }
}

namespace {

/// Samples of one level around a group of layers of bricks, or a band of its rows of bricks: its own and one
/// more on both sides, along y and z, where there is one.
struct Window {
    glm::ivec3 extent{0};          // of the whole level
    glm::ivec3 first{0}, end{0};   // along x all of it
    std::vector<std::byte> values; // [end - first], stored type

    glm::ivec3 size() const { return end - first; }
};

/// Samples of a window along y or z, around so many bricks.
int windowLength(int bricks, int level) {
    return (bricks * kBrickExtent >> level) + 2;
}

/// Tells a source all chunks of a pass over it.
template <typename KeyOf> void tellChunks(const ChunkSource& volume, std::size_t count, const KeyOf& keyOf) {
    std::vector<ChunkKey> keys(count);
    for (std::size_t n = 0; n < count; ++n)
        keys[n] = keyOf(n);
    volume.willRead(keys);
}

/// @param firstBrick, endBrick  of the group or band
void loadWindow(const ChunkSource& volume, int level, const glm::ivec3& firstBrick,
                const glm::ivec3& endBrick, BufferPool& pool, int threads, Window& window) {
    const std::size_t bytes = bytesPerValue(volume.info().type);
    const int brick = kBrickExtent >> level;
    window.first = glm::max(firstBrick * brick - 1, glm::ivec3(0));
    window.end = glm::min(endBrick * brick + 1, window.extent);
    const glm::ivec3 firstChunk = window.first / kChunkExtent;
    const glm::ivec3 grid = (window.end - 1) / kChunkExtent + 1 - firstChunk;
    const auto keyOf = [&](std::size_t n) {
        const glm::ivec3 chunk = gridPosition(n, grid) + firstChunk;
        return ChunkKey{level, chunk.x, chunk.y, chunk.z};
    };
    tellChunks(volume, cellCount(grid), keyOf);
    parallelFor(cellCount(grid), threads, [&](std::size_t n) {
        const ChunkKey key = keyOf(n);
        const BufferPool::Lease buffer(pool);
        volume.readChunk(key, buffer.bytes());
        const glm::ivec3 origin = glm::ivec3(key.i, key.j, key.k) * kChunkExtent;
        const glm::ivec3 low = glm::max(origin, window.first);
        const glm::ivec3 high = glm::min(origin + kChunkExtent, window.end);
        for (int z = low.z; z < high.z; ++z)
            for (int y = low.y; y < high.y; ++y)
                std::memcpy(window.values.data() +
                                linearIndex(glm::ivec3(low.x, y, z) - window.first, window.size()) * bytes,
                            buffer.bytes().data() +
                                linearIndex(glm::ivec3(low.x, y, z) - origin, glm::ivec3(kChunkExtent)) *
                                    bytes,
                            static_cast<std::size_t>(high.x - low.x) * bytes);
    });
}

/// A thread's room for one brick's fields as floats.
constexpr std::size_t kFieldFloats = [] {
    std::size_t floats = std::size_t{kBrickExtent} * kBrickExtent * kBrickExtent;
    for (int level = 1; level < kLevelCount; ++level) {
        const auto edge = static_cast<std::size_t>((kBrickExtent >> level) + 2);
        floats += edge * edge * edge;
    }
    return floats;
}();

template <typename Value>
BrickFields fieldsOf(const glm::ivec3& brick, const glm::ivec3& valid, const Value* chunk,
                     const std::array<Window, kLevelCount>& windows, std::span<float> room) {
    const auto take = [&](std::size_t floats) {
        const std::span<float> taken = room.first(floats);
        room = room.subspan(floats);
        return taken;
    };
    BrickFields fields;
    fields.size = valid;
    fields.isWhole = sizeof(Value) <= 2;
    const std::span<float> voxels = take(cellCount(valid));
    float* to = voxels.data();
    for (int z = 0; z < valid.z; ++z)
        for (int y = 0; y < valid.y; ++y) {
            const Value* row = chunk + linearIndex({0, y, z}, glm::ivec3(kChunkExtent));
            for (int x = 0; x < valid.x; ++x)
                *to++ = static_cast<float>(row[x]);
        }
    fields.voxels = voxels;
    for (int level = 1; level < kLevelCount; ++level) {
        const Window& window = windows[static_cast<std::size_t>(level)];
        BrickFields::Box& box = fields.levels[static_cast<std::size_t>(level)];
        const glm::ivec3 own = brick * (kBrickExtent >> level);
        const glm::ivec3 first = glm::max(own - 1, glm::ivec3(0));
        const glm::ivec3 end = glm::min(own + (kBrickExtent >> level) + 1, window.extent);
        box.first = first - own;
        box.extent = end - first;
        const std::span<float> samples = take(cellCount(box.extent));
        float* out = samples.data();
        const auto* values = reinterpret_cast<const Value*>(window.values.data());
        for (int z = first.z; z < end.z; ++z)
            for (int y = first.y; y < end.y; ++y) {
                const Value* row = values + linearIndex(glm::ivec3(0, y, z) - window.first, window.size());
                for (int x = first.x; x < end.x; ++x)
                    *out++ = static_cast<float>(row[x]);
            }
        box.samples = samples;
    }
    return fields;
}

/// Counts the valid voxels of a chunk into a histogram that threads share.
template <typename Value>
void countChunk(const Binner<Value>& binOf, const glm::ivec3& valid, const Value* chunk, std::mutex& mutex,
                std::vector<std::uint64_t>& histogram) {
    if (isOneValue(chunk, valid)) {
        const std::lock_guard lock(mutex);
        histogram[binOf(chunk[0])] += cellCount(valid);
        return;
    }
    // Several counters a bin: neighbours are often of one bin, and each waits for the one before.
    constexpr std::size_t kCounters = 4;
    std::array<std::array<std::uint32_t, kHistogramBins>, kCounters> counts{};
    for (int z = 0; z < valid.z; ++z)
        for (int y = 0; y < valid.y; ++y) {
            const Value* row = chunk + linearIndex({0, y, z}, glm::ivec3(kChunkExtent));
            int x = 0;
            for (; x + static_cast<int>(kCounters) <= valid.x; x += static_cast<int>(kCounters))
                for (std::size_t n = 0; n < kCounters; ++n)
                    ++counts[n][binOf(row[static_cast<std::size_t>(x) + n])];
            for (; x < valid.x; ++x)
                ++counts[0][binOf(row[x])];
        }
    const std::lock_guard lock(mutex);
    for (const auto& some : counts)
        for (std::size_t bin = 0; bin < some.size(); ++bin)
            histogram[bin] += some[bin];
}

/// Of the most samples that a level's window has around so many rows of bricks.
glm::ivec3 windowExtent(const VolumeInfo& info, int level, int brickRows) {
    const glm::ivec3 extent = levelExtent(info.extentVoxels, level);
    return glm::min(extent, {extent.x, windowLength(brickRows, level), windowLength(kRayLayers, level)});
}

std::size_t windowBytes(const VolumeInfo& info, int brickRows) {
    std::size_t bytes = 0;
    for (int level = 1; level < kLevelCount; ++level)
        bytes += cellCount(windowExtent(info, level, brickRows)) * bytesPerValue(info.type);
    return bytes;
}

} // namespace

// All rows, or as many as have room. Chunks of level 1 hold two rows of bricks, and those at a band's ends
// are read twice.
int rayBandRows(const VolumeInfo& info, std::size_t freeBytes) {
    const int all = brickGrid(info.extentVoxels).y;
    int rows = all;
    while (rows > 1 && windowBytes(info, rows) > (rows == all ? freeBytes : freeBytes / 4 * 3))
        rows = (rows + 1) / 2;
    return rows;
}

void gatherHistogram(const StoreReader& store, WholeRange& whole, BufferPool& pool, int threads) {
    const VolumeInfo& info = store.info();
    const glm::ivec3 grid = chunkGrid(info.extentVoxels, 0);
    std::mutex mutex;
    withValueType(info.type, [&](auto example) {
        using Value = decltype(example);
        const Binner<Value> binOf(whole.lowest, whole.highest);
        parallelFor(cellCount(grid), threads, [&](std::size_t n) {
            const glm::ivec3 chunk = gridPosition(n, grid);
            const BufferPool::Lease buffer(pool);
            store.readChunk({0, chunk.x, chunk.y, chunk.z}, buffer.bytes());
            countChunk(binOf, glm::min(info.extentVoxels - chunk * kChunkExtent, glm::ivec3(kChunkExtent)),
                       reinterpret_cast<const Value*>(buffer.bytes().data()), mutex, whole.histogram);
        });
    });
}

std::size_t fieldBytes(int threads) {
    return static_cast<std::size_t>(threads > 0 ? threads : defaultThreads()) * kFieldFloats * sizeof(float);
}

std::size_t rayScratchBytes(const VolumeInfo& info, int threads) {
    return fieldBytes(threads) + windowBytes(info, 1);
}

FoundRange gatherRays(const ChunkSource& volume, WholePass* whole, BufferPool& pool, MemoryBudget& ram,
                      int bandRows, int threads, const std::function<bool(std::size_t)>& wanted,
                      const BrickRaysDone& brickDone, const std::function<void(int)>& groupDone) {
    static_assert(kBrickExtent == kChunkExtent, "a chunk of level 0 is a brick");
    const VolumeInfo& info = volume.info();
    const glm::ivec3 bricks = brickGrid(info.extentVoxels);
    BufferPool rooms(ram, static_cast<std::size_t>(threads > 0 ? threads : defaultThreads()),
                     kFieldFloats * sizeof(float), "sampling rays");
    const Charge charge = ram.charge(windowBytes(info, bandRows), "sampling rays");
    std::array<Window, kLevelCount> windows;
    for (int level = 1; level < kLevelCount; ++level) {
        Window& window = windows[static_cast<std::size_t>(level)];
        window.extent = levelExtent(info.extentVoxels, level);
        window.values.resize(cellCount(windowExtent(info, level, bandRows)) * bytesPerValue(info.type));
    }
    FoundRange range;
    std::mutex mutex;
    withValueType(info.type, [&](auto example) {
        using Value = decltype(example);
        const Binner<Value> binOf(whole ? whole->range.lowest : 0, whole ? whole->range.highest : 0);
        const auto sampleBand = [&](const glm::ivec3& first, const glm::ivec3& end) {
            const glm::ivec3 grid = end - first;
            const auto placeOf = [&](std::size_t n) { // of a brick in the volume
                return linearIndex(gridPosition(n, grid) + first, bricks);
            };
            bool any = whole != nullptr;
            for (std::size_t n = 0; n < cellCount(grid) && !any; ++n)
                any = wanted(placeOf(n));
            if (!any)
                return;
            for (int level = 1; level < kLevelCount; ++level)
                loadWindow(volume, level, first, end, pool, threads,
                           windows[static_cast<std::size_t>(level)]);
            std::vector<ChunkKey> read;
            for (std::size_t n = 0; n < cellCount(grid); ++n)
                if (wanted(placeOf(n)) || whole) {
                    const glm::ivec3 brick = gridPosition(n, grid) + first;
                    read.push_back({0, brick.x, brick.y, brick.z});
                }
            volume.willRead(read);
            if (whole)
                whole->cells.begin(first, end), whole->wide.begin(first, end);
            parallelFor(cellCount(grid), threads, [&](std::size_t n) {
                const bool want = wanted(placeOf(n));
                if (!want && !whole)
                    return;
                const glm::ivec3 brick = gridPosition(n, grid) + first;
                const glm::ivec3 valid =
                    glm::min(info.extentVoxels - brick * kBrickExtent, glm::ivec3(kBrickExtent));
                const BufferPool::Lease buffer(pool);
                volume.readChunk({0, brick.x, brick.y, brick.z}, buffer.bytes());
                const auto* values = reinterpret_cast<const Value*>(buffer.bytes().data());
                if (whole) {
                    mergeChunk<Value>(brick, valid, buffer.bytes(), whole->cells.window(),
                                      whole->wide.window(), range, mutex);
                    countChunk(binOf, valid, values, mutex, whole->range.histogram);
                }
                if (!want)
                    return;
                const BufferPool::Lease room(rooms);
                const std::span<float> floats(reinterpret_cast<float*>(room.bytes().data()), kFieldFloats);
                brickDone(placeOf(n), sampleRays(fieldsOf(brick, valid, values, windows, floats)));
            });
            if (whole)
                whole->cells.end(), whole->wide.end();
        };
        for (int group = 0; group * kRayLayers < bricks.z; ++group) {
            const int firstZ = group * kRayLayers, endZ = std::min(firstZ + kRayLayers, bricks.z);
            for (int row = 0; row < bricks.y; row += bandRows)
                sampleBand({0, row, firstZ}, {bricks.x, std::min(row + bandRows, bricks.y), endZ});
            groupDone(group);
        }
    });
    return range;
}

} // namespace tessera

// bricking/store/level_writer.cpp: see level_writer.h. A slab is divided into chunks, compressed in parallel
// a batch at a time, and appended to their shards in a fixed order: that of the index. So the same volume
// gives the same files, and the chunks of a part are contiguous in a shard of the whole.
#include "bricking/store/level_writer.h"

#include "bricking/store/codec.h"
#include "bricking/store/shard.h"
#include "bricking/store/store_files.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr int kSlotsPerThread = 4; // two batches of chunks: enough to hide one slow chunk

/// A shard while it grows.
struct GrowingShard {
    std::uint64_t bytes = 0; // appended so far
    std::vector<ShardEntry> index;
    std::vector<std::uint32_t> crcs; // per index entry, of written chunks
};
constexpr std::size_t kEntryBytes = sizeof(ShardEntry) + sizeof(std::uint32_t);

struct GrowingLevel {
    glm::ivec3 extent{0};
    ShardLayout layout;
    int rowZ = 0;                      // of the row of shards that slabs fill now
    std::vector<GrowingShard> growing; // [y][x]: that row
};

/// Buffers for one chunk.
struct Slot {
    ChunkKey key;
    std::vector<std::byte> raw, encoded;
    EncodedChunk result; // 0 bytes: all fill, not written
    double lowest = 0, highest = 0;
    bool finite = true;
};

int threadCount(int threads) {
    return threads > 0 ? threads : defaultThreads();
}
std::size_t slotCount(int threads) {
    return static_cast<std::size_t>(kSlotsPerThread * threadCount(threads));
}

std::size_t chunkBytesOf(const VolumeInfo& info) {
    return cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info.type);
}
std::size_t slotBytes(const VolumeInfo& info) {
    return chunkBytesOf(info) + encodedBound(chunkBytesOf(info));
}
std::size_t indexBytesOf(const VolumeInfo& info) {
    std::size_t bytes = 0;
    for (int level = 0; level < kLevelCount; ++level) {
        const ShardLayout layout = shardLayout(levelExtent(info.extentVoxels, level));
        bytes += cellCount({layout.shards.x, layout.shards.y, 1}) * layout.entries() * kEntryBytes;
    }
    return bytes;
}

template <typename Value> void scanRow(const std::byte* row, int count, Slot& slot) {
    const auto* values = reinterpret_cast<const Value*>(row);
    Value lowest = values[0], highest = values[0];
    for (int i = 0; i < count; ++i) {
        if constexpr (std::is_floating_point_v<Value>)
            slot.finite = slot.finite && std::isfinite(values[i]);
        lowest = std::min(lowest, values[i]);
        highest = std::max(highest, values[i]);
    }
    slot.lowest = std::min(slot.lowest, static_cast<double>(lowest));
    slot.highest = std::max(slot.highest, static_cast<double>(highest));
}

void scanRow(ValueType type, const std::byte* row, int count, Slot& slot) {
    switch (type) {
    case ValueType::u8:
        return scanRow<std::uint8_t>(row, count, slot);
    case ValueType::i16:
        return scanRow<std::int16_t>(row, count, slot);
    case ValueType::u16:
        return scanRow<std::uint16_t>(row, count, slot);
    case ValueType::f32:
        return scanRow<float>(row, count, slot);
    }
}

} // namespace

std::uint64_t WrittenLevels::bytes() const {
    std::uint64_t sum = 0;
    for (const ShardFile& file : files)
        sum += file.bytes;
    return sum;
}

struct LevelWriter::State {
    State(fs::path into, const VolumeInfo& volume, MemoryBudget& ram, int threadsWanted, Codec chosen);

    void prepare(Slot& slot, const SlabPyramid::Slab& slab) const;
    void append(std::span<const Slot> slots);
    void closeRow(int level);

    fs::path folder;
    VolumeInfo info;
    Codec codec;
    int threads;
    Charge charge;
    std::vector<std::byte> fillChunk;
    std::array<GrowingLevel, kLevelCount> levels;
    std::vector<Slot> slots;
    WrittenLevels written;
};

LevelWriter::State::State(fs::path into, const VolumeInfo& volume, MemoryBudget& ram, int threadsWanted,
                          Codec chosen)
    : folder(std::move(into)), info(volume), codec(chosen), threads(threadCount(threadsWanted)),
      charge(ram.charge(bytesNeeded(info, threads), "compressing chunks")) {
    fillChunk.resize(chunkBytesOf(info));
    fillWith(info, fillChunk);
    slots.resize(slotCount(threads));
    for (Slot& slot : slots) {
        slot.raw.resize(chunkBytesOf(info));
        slot.encoded.resize(encodedBound(slot.raw.size()));
    }
    for (int l = 0; l < kLevelCount; ++l) {
        GrowingLevel& level = levels[static_cast<std::size_t>(l)];
        level.extent = levelExtent(info.extentVoxels, l);
        level.layout = shardLayout(level.extent);
        level.growing.resize(cellCount({level.layout.shards.x, level.layout.shards.y, 1}));
        for (GrowingShard& shard : level.growing) {
            shard.index.resize(level.layout.entries());
            shard.crcs.resize(level.layout.entries());
        }
    }
}

LevelWriter::LevelWriter(fs::path folder, const VolumeInfo& info, MemoryBudget& ram, int threads, Codec codec)
    : state_(std::make_unique<State>(std::move(folder), info, ram, threads, codec)) {}
LevelWriter::~LevelWriter() = default;

std::size_t LevelWriter::bytesNeeded(const VolumeInfo& info, int threads) {
    return indexBytesOf(info) + slotCount(threads) * slotBytes(info) + chunkBytesOf(info);
}

void LevelWriter::write(const SlabPyramid::Slab& slab) {
    State& s = *state_;
    GrowingLevel& level = s.levels[static_cast<std::size_t>(slab.level)];
    const glm::ivec3 grid = ceilDiv(level.extent, kChunkExtent);
    const int k = slab.firstSlice / kChunkExtent;
    level.rowZ = k / level.layout.chunks.z;
    TESSERA_CHECK(slab.firstRow % kChunkExtent == 0);
    const int firstRow = slab.firstRow / kChunkExtent; // of chunks
    const int endRow = firstRow + (slab.rows - 1) / kChunkExtent + 1;
    // One half of the slots is compressed while the other one, the batch before, is written.
    const std::size_t half = s.slots.size() / 2;
    std::span<Slot> batch = std::span(s.slots).first(half), before = std::span(s.slots).subspan(half, half);
    std::size_t used = 0, unwritten = 0; // of the batch; of the one before
    const auto flush = [&] {
        const std::size_t writing = unwritten > 0 ? 1 : 0;
        parallelFor(used + writing, s.threads, [&](std::size_t i) {
            if (i < writing)
                s.append(before.first(unwritten));
            else
                s.prepare(batch[i - writing], slab);
        });
        std::swap(batch, before);
        unwritten = std::exchange(used, 0);
    };
    // Shard after shard, so that each is opened about once per slab.
    for (int sy = 0; sy < level.layout.shards.y; ++sy)
        for (int sx = 0; sx < level.layout.shards.x; ++sx) {
            const glm::ivec3 first = glm::ivec3(sx, sy, 0) * level.layout.chunks;
            const glm::ivec3 end = glm::min(first + level.layout.chunks, grid);
            for (int j = std::max(first.y, firstRow); j < std::min(end.y, endRow); ++j)
                for (int i = first.x; i < end.x; ++i) {
                    batch[used++].key = {slab.level, i, j, k};
                    if (used == batch.size())
                        flush();
                }
        }
    flush();
    s.append(before.first(unwritten));
    if (endRow == grid.y && (k + 1 == grid.z || (k + 1) % level.layout.chunks.z == 0))
        s.closeRow(slab.level);
}

void LevelWriter::State::prepare(Slot& slot, const SlabPyramid::Slab& slab) const {
    const glm::ivec3 extent(levels[static_cast<std::size_t>(slab.level)].extent.x, slab.rows, slab.slices);
    const std::size_t valueBytes = bytesPerValue(info.type);
    const glm::ivec3 first(slot.key.i * kChunkExtent, slot.key.j * kChunkExtent - slab.firstRow, 0);
    const glm::ivec3 size = glm::min(extent - first, glm::ivec3(kChunkExtent));
    slot.lowest = std::numeric_limits<double>::infinity();
    slot.highest = -slot.lowest;
    slot.finite = true;
    if (size != glm::ivec3(kChunkExtent))
        slot.raw = fillChunk;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y) {
            const std::byte* from =
                slab.values.data() + linearIndex(first + glm::ivec3(0, y, z), extent) * valueBytes;
            std::byte* to = slot.raw.data() + linearIndex({0, y, z}, glm::ivec3(kChunkExtent)) * valueBytes;
            std::memcpy(to, from, static_cast<std::size_t>(size.x) * valueBytes);
            if (slab.level == 0)
                scanRow(info.type, from, size.x, slot);
        }
    slot.result = encodeUnlessFill(slot.raw, fillChunk, valueBytes, slot.encoded, codec);
}

void LevelWriter::State::append(std::span<const Slot> batch) {
    std::optional<FileHandle> file;
    fs::path path;
    for (const Slot& slot : batch) {
        const ChunkKey& key = slot.key;
        GrowingLevel& level = levels[static_cast<std::size_t>(key.level)];
        if (!slot.finite)
            throw badFile("the source", "finite values", "a value that is not, in " + describe(key));
        if (key.level == 0) {
            written.lowest = std::min(written.lowest, slot.lowest);
            written.highest = std::max(written.highest, slot.highest);
        }
        if (slot.result.bytes == 0) {
            ++written.chunksFill;
            continue;
        }
        const glm::ivec3 at = level.layout.shardOf(key);
        GrowingShard& shard = level.growing[linearIndex({at.x, at.y, 0}, level.layout.shards)];
        const fs::path shardFile = folder / shardPath(key.level, at);
        if (!file || shardFile != path) {
            if (file)
                file->close(path.string());
            path = shardFile;
            if (shard.bytes == 0)
                fs::create_directories(path.parent_path());
            file = openForWriting(path);
        }
        const std::size_t entry = level.layout.entryOf(key);
        writeAt(*file, shard.bytes, std::span(slot.encoded).first(slot.result.bytes), path);
        shard.index[entry] = {shard.bytes, slot.result.bytes};
        shard.crcs[entry] = slot.result.crc;
        shard.bytes += slot.result.bytes;
        ++written.chunksWritten;
    }
    if (file)
        file->close(path.string());
}

void LevelWriter::State::closeRow(int l) {
    GrowingLevel& level = levels[static_cast<std::size_t>(l)];
    for (int y = 0; y < level.layout.shards.y; ++y)
        for (int x = 0; x < level.layout.shards.x; ++x) {
            GrowingShard& shard = level.growing[linearIndex({x, y, 0}, level.layout.shards)];
            if (shard.bytes > 0) {
                const std::vector<std::byte> index = encodeIndex(shard.index);
                const glm::ivec3 at(x, y, level.rowZ);
                const fs::path path = folder / shardPath(l, at);
                FileHandle file = openForWriting(path);
                writeAt(file, shard.bytes, index, path);
                file.close(path.string());
                written.files.push_back(
                    {l, at, shard.bytes + index.size(), shardRecord(shard.index, shard.crcs, index)});
            }
            shard.bytes = 0;
            std::fill(shard.index.begin(), shard.index.end(), ShardEntry{});
        }
}

void LevelWriter::close() {
    for (int level = 0; level < kLevelCount; ++level)
        state_->closeRow(level);
    std::vector<Slot>().swap(state_->slots);
    std::vector<std::byte>().swap(state_->fillChunk);
    for (GrowingLevel& level : state_->levels)
        std::vector<GrowingShard>().swap(level.growing);
    { const Charge returned = std::move(state_->charge); }
}

const WrittenLevels& LevelWriter::written() const {
    return state_->written;
}

} // namespace tessera

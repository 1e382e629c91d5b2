// bricking/store/store_writer.cpp: see store_writer.h. Slabs of any level are divided into chunks, compressed
// in parallel a batch at a time, and appended to their shards in a fixed order. So the same volume gives the
// same files.
#include "bricking/store/store_writer.h"

#include "bricking/store/codec.h"
#include "bricking/store/pyramid.h"
#include "bricking/store/shard.h"
#include "bricking/store/store_files.h"
#include "bricking/store/store_reader.h"
#include "bricking/store/zarr_metadata.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr int kSlotsPerThread = 4; // chunks compressed per batch: enough to hide one slow chunk

/// A shard while it grows.
struct GrowingShard {
    std::uint64_t bytes = 0; // appended so far
    std::vector<ShardEntry> index;
    std::vector<std::uint32_t> crcs; // per index entry, of written chunks
};
constexpr std::size_t kEntryBytes = sizeof(ShardEntry) + sizeof(std::uint32_t);

struct LevelState {
    glm::ivec3 extent{0};
    ShardLayout layout;
    std::vector<GrowingShard> growing; // [y][x]: the row of shards that slabs fill now
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

struct StoreWriter::State {
    State(const fs::path& storeAt, const VolumeInfo& volume, MemoryBudget& ram, int threadsWanted,
          bool replace, PyramidRule rule);

    void writeSlab(const SlabPyramid::Slab& slab);
    void prepare(Slot& slot, const SlabPyramid::Slab& slab) const;
    void append(std::span<const Slot> slots);
    void closeRow(int level, int shardZ);

    fs::path target;
    bool force;
    VolumeInfo info;
    int threads;
    TemporaryFolder folder;
    std::vector<std::byte> fillChunk;
    Charge charge;
    std::array<LevelState, kLevelCount> levels;
    std::vector<Slot> slots;
    std::optional<SlabPyramid> pyramid;
    StoreMetadata metadata;
    Counters counters;
    bool finished = false;
};

void checkStoreTarget(const fs::path& target, const VolumeInfo& info, bool force) {
    checkStorable(info, target.string());
    std::error_code ignored;
    if (fs::symlink_status(target, ignored).type() != fs::file_type::not_found) {
        if (!isStore(target))
            throw badFile(target.string(), "a new name or a store of Tessera",
                          "something else; it is left alone");
        if (!force)
            throw badFile(target.string(), "a new name, or --force to replace", "an existing store");
    }
}

namespace {
/// All checks before a folder is made.
const fs::path& checkedTarget(const fs::path& target, const VolumeInfo& info, bool force) {
    checkStoreTarget(target, info, force);
    return target;
}
} // namespace

StoreWriter::State::State(const fs::path& storeAt, const VolumeInfo& volume, MemoryBudget& ram,
                          int threadsWanted, bool replace, PyramidRule rule)
    : target(storeAt), force(replace), info(withPlainTexts(volume)), threads(threadCount(threadsWanted)),
      folder(checkedTarget(target, info, force)) {
    // The total first, so that the message names the minimum and not one of its parts.
    { const Charge floor = ram.charge(floorBytes(info, threads), "importing a volume this wide"); }
    charge = ram.charge(indexBytesOf(info) + slotCount(threads) * slotBytes(info) + chunkBytesOf(info),
                        "compressing chunks");
    fillChunk.resize(chunkBytesOf(info));
    fillWith(info, fillChunk);
    slots.resize(slotCount(threads));
    for (Slot& slot : slots) {
        slot.raw.resize(chunkBytesOf(info));
        slot.encoded.resize(encodedBound(slot.raw.size()));
    }
    metadata.rule = rule.name;
    metadata.lowest = std::numeric_limits<double>::infinity();
    metadata.highest = -metadata.lowest;
    for (int l = 0; l < kLevelCount; ++l) {
        LevelState& level = levels[static_cast<std::size_t>(l)];
        level.extent = levelExtent(info.extentVoxels, l);
        level.layout = shardLayout(level.extent);
        level.growing.resize(cellCount({level.layout.shards.x, level.layout.shards.y, 1}));
        for (GrowingShard& shard : level.growing) {
            shard.index.resize(level.layout.entries());
            shard.crcs.resize(level.layout.entries());
        }
        metadata.shards[static_cast<std::size_t>(l)].resize(cellCount(level.layout.shards));
    }
    pyramid.emplace(
        info.extentVoxels, info.type, ram, threads,
        [this](const SlabPyramid::Slab& slab) { writeSlab(slab); }, std::move(rule));
}

void StoreWriter::State::writeSlab(const SlabPyramid::Slab& slab) {
    const LevelState& level = levels[static_cast<std::size_t>(slab.level)];
    const glm::ivec3 grid = ceilDiv(level.extent, kChunkExtent);
    const int k = slab.firstSlice / kChunkExtent;
    std::size_t used = 0;
    const auto flush = [&] {
        parallelFor(used, threads, [&](std::size_t i) { prepare(slots[i], slab); });
        append(std::span(slots).first(used));
        used = 0;
    };
    // Shard after shard, so that each is opened about once per slab.
    for (int sy = 0; sy < level.layout.shards.y; ++sy)
        for (int sx = 0; sx < level.layout.shards.x; ++sx) {
            const glm::ivec3 first = glm::ivec3(sx, sy, 0) * level.layout.chunks;
            const glm::ivec3 end = glm::min(first + level.layout.chunks, grid);
            for (int j = first.y; j < end.y; ++j)
                for (int i = first.x; i < end.x; ++i) {
                    slots[used++].key = {slab.level, i, j, k};
                    if (used == slots.size())
                        flush();
                }
        }
    flush();
    const int shardChunks = level.layout.chunks.z;
    if (k + 1 == grid.z || (k + 1) % shardChunks == 0)
        closeRow(slab.level, k / shardChunks);
}

void StoreWriter::State::prepare(Slot& slot, const SlabPyramid::Slab& slab) const {
    const glm::ivec3 extent = levels[static_cast<std::size_t>(slab.level)].extent;
    const std::size_t valueBytes = bytesPerValue(info.type);
    const glm::ivec3 first(slot.key.i * kChunkExtent, slot.key.j * kChunkExtent, 0);
    const glm::ivec3 size =
        glm::min(glm::ivec3(extent.x, extent.y, slab.slices) - first, glm::ivec3(kChunkExtent));
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
    slot.result = encodeUnlessFill(slot.raw, fillChunk, valueBytes, slot.encoded);
}

void StoreWriter::State::append(std::span<const Slot> batch) {
    std::optional<FileHandle> file;
    fs::path path;
    for (const Slot& slot : batch) {
        const ChunkKey& key = slot.key;
        LevelState& level = levels[static_cast<std::size_t>(key.level)];
        if (!slot.finite)
            throw badFile("the source", "finite values", "a value that is not, in " + describe(key));
        if (key.level == 0) {
            metadata.lowest = std::min(metadata.lowest, slot.lowest);
            metadata.highest = std::max(metadata.highest, slot.highest);
        }
        if (slot.result.bytes == 0) {
            ++counters.chunksFill;
            continue;
        }
        const glm::ivec3 at = level.layout.shardOf(key);
        const fs::path shardFile = folder.path() / shardPath(key.level, at);
        if (!file || shardFile != path) {
            if (file)
                file->close(path.string());
            path = shardFile;
            fs::create_directories(path.parent_path());
            file = openForWriting(path);
        }
        GrowingShard& shard = level.growing[linearIndex({at.x, at.y, 0}, level.layout.shards)];
        const std::size_t entry = level.layout.entryOf(key);
        writeAt(*file, shard.bytes, std::span(slot.encoded).first(slot.result.bytes), path);
        shard.index[entry] = {shard.bytes, slot.result.bytes};
        shard.crcs[entry] = slot.result.crc;
        shard.bytes += slot.result.bytes;
        ++counters.chunksWritten;
    }
    if (file)
        file->close(path.string());
}

void StoreWriter::State::closeRow(int l, int shardZ) {
    LevelState& level = levels[static_cast<std::size_t>(l)];
    for (int y = 0; y < level.layout.shards.y; ++y)
        for (int x = 0; x < level.layout.shards.x; ++x) {
            GrowingShard& shard = level.growing[linearIndex({x, y, 0}, level.layout.shards)];
            if (shard.bytes > 0) {
                const std::vector<std::byte> index = encodeIndex(shard.index);
                metadata
                    .shards[static_cast<std::size_t>(l)][linearIndex({x, y, shardZ}, level.layout.shards)] =
                    shardRecord(shard.index, shard.crcs, index);
                const fs::path path = folder.path() / shardPath(l, {x, y, shardZ});
                FileHandle file = openForWriting(path);
                writeAt(file, shard.bytes, index, path);
                file.close(path.string());
                counters.bytesWritten += shard.bytes + index.size();
            }
            shard.bytes = 0;
            std::fill(shard.index.begin(), shard.index.end(), ShardEntry{});
        }
}

StoreWriter::StoreWriter(const fs::path& target, const VolumeInfo& info, MemoryBudget& ram, int threads,
                         bool force, PyramidRule rule)
    : state_(std::make_unique<State>(target, info, ram, threads, force, std::move(rule))) {}
StoreWriter::~StoreWriter() = default;

std::size_t StoreWriter::floorBytes(const VolumeInfo& info, int threads) {
    return SlabPyramid::bytesNeeded(info.extentVoxels, info.type) + indexBytesOf(info) +
           slotCount(threads) * slotBytes(info) + chunkBytesOf(info);
}

int StoreWriter::nextSlices() const {
    return state_->pyramid ? state_->pyramid->nextSlices() : 0;
}
std::span<std::byte> StoreWriter::next() {
    return state_->pyramid->next();
}
void StoreWriter::push() {
    state_->pyramid->push();
}

void StoreWriter::finish(const VolumeInfo& final, const std::string& imageLabel) {
    State& s = *state_;
    TESSERA_CHECK(s.pyramid && s.pyramid->nextSlices() == 0);
    s.pyramid.reset();
    s.info.nonFiniteVoxels = final.nonFiniteVoxels;
    s.info.absentStored = final.absentStored;
    s.info.clampedVoxels = final.clampedVoxels;
    s.info.lossy = final.lossy;
    s.info.remarks = withPlainTexts(final).remarks;
    s.metadata.info = s.info;
    s.metadata.imageLabel = imageLabel;
    for (int level = 0; level < kLevelCount; ++level) {
        const std::string text = levelDocument(s.info, level);
        const fs::path folder = s.folder.path() / std::to_string(level);
        fs::create_directories(folder); // a level of fill alone has no shard
        writeFile(folder / "zarr.json", text);
        s.counters.bytesWritten += text.size();
    }
    const std::string text = groupDocument(s.metadata);
    if (text.size() > kMaxMetadataBytes)
        throw badFile(s.folder.path().string(), "metadata of at most 16 MiB", "a volume with more shards");
    writeFile(s.folder.path() / "zarr.json", text);
    s.counters.bytesWritten += text.size();
    std::vector<Slot>().swap(s.slots);
    std::vector<std::byte>().swap(s.fillChunk);
    for (LevelState& level : s.levels)
        std::vector<GrowingShard>().swap(level.growing);
    { const Charge returned = std::move(s.charge); }
    s.finished = true;
}

void StoreWriter::commit(bool durable) {
    TESSERA_CHECK(state_->finished);
    checkedTarget(state_->target, state_->info, state_->force); // something may have appeared there meanwhile
    state_->folder.commit(durable, state_->force);
}

const fs::path& StoreWriter::folder() const {
    return state_->folder.path();
}
StoreWriter::Counters StoreWriter::counters() const {
    return state_->counters;
}

} // namespace tessera

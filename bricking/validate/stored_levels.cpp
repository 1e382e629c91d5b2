// bricking/validate/stored_levels.cpp: the checks of StoredLevels: see stored_levels.h.
#include "bricking/validate/stored_levels.h"

#include "bricking/labels/label_majority.h"
#include "bricking/store/codec.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace tessera {
namespace {

constexpr int kBoxExtent = 2 * kChunkExtent; // samples of a level that make a chunk of the next
constexpr std::size_t kShardSlots = 16;

std::size_t roundedUp(std::size_t bytes) {
    return (bytes + 63) / 64 * 64;
}

} // namespace

StoredLevels::StoredLevels(const std::filesystem::path& path, const StoreMetadata& metadata,
                           MemoryBudget& ram, int threads, StoreFaults& faults)
    : metadata_(metadata), ram_(ram), faults_(faults), valueBytes_(bytesPerValue(metadata.info.type)),
      chunkBytes_(cellCount(glm::ivec3(kChunkExtent)) * valueBytes_) {
    std::size_t held = chunkBytes_;
    for (int level = 0; level < kLevelCount; ++level)
        held += cellCount(chunkGrid(metadata.info.extentVoxels, level)) +
                metadata.shards[static_cast<std::size_t>(level)].size();
    charge_ = ram.charge(held, "the chunks of a store");
    fillChunk_.resize(chunkBytes_);
    fillWith(metadata.info, fillChunk_);
    for (int level = 0; level < kLevelCount; ++level) {
        Level& own = levels_[static_cast<std::size_t>(level)];
        own.extent = levelExtent(metadata.info.extentVoxels, level);
        own.grid = ceilDiv(own.extent, kChunkExtent);
        own.chunks.resize(cellCount(own.grid));
        own.shards.resize(metadata.shards[static_cast<std::size_t>(level)].size());
    }
    const std::size_t indices =
        std::clamp<std::size_t>(ram.freeBytes() / 8 / largestIndexBytes(metadata.info), 1, kShardSlots);
    files_.emplace(path, metadata, ram, indices);
    // A repaired shard has a batch of encoded chunks besides.
    const std::size_t each = roomBytes() + encodedBound(chunkBytes_);
    const auto wanted = static_cast<std::size_t>(threads > 0 ? threads : defaultThreads());
    threads_ = std::clamp<std::size_t>(ram.freeBytes() / each, 1, wanted);
    pool_.emplace(ram, threads_, roomBytes(), "checking chunks");
    lowest_ = std::numeric_limits<double>::infinity();
    highest_ = -lowest_;
}

std::size_t StoredLevels::roomBytes() const {
    return 8 * chunkBytes_ + 2 * chunkBytes_ + roundedUp(encodedBound(chunkBytes_));
}

StoredLevels::Room StoredLevels::roomOf(const BufferPool::Lease& lease) const {
    const std::span<std::byte> all = lease.bytes();
    return {all.first(8 * chunkBytes_), all.subspan(8 * chunkBytes_, chunkBytes_),
            all.subspan(9 * chunkBytes_, chunkBytes_), all.subspan(10 * chunkBytes_)};
}

std::uint8_t& StoredLevels::stateOf(const ChunkKey& key) {
    Level& level = levels_[static_cast<std::size_t>(key.level)];
    return level.chunks[linearIndex({key.i, key.j, key.k}, level.grid)];
}

void StoredLevels::check(const ShareDone& progress) {
    const std::size_t first = faults_.listed();
    for (int level = 0; level < kLevelCount; ++level)
        parallelFor(levels_[static_cast<std::size_t>(level)].shards.size(), static_cast<int>(threads_),
                    [&](std::size_t shard) { checkShard(level, shard); });
    findRule();
    for (int level = 0; level < kLevelCount; ++level)
        checkLevel(level, level == 0 ? progress : ShareDone{});
    finishShards();
    faults_.sortFrom(first);
}

/// The file of a shard: its index, and that its chunks fill the rest of it.
void StoredLevels::checkShard(int l, std::size_t n) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    const ShardLayout& layout = files_->layout(l);
    const glm::ivec3 at = gridPosition(n, layout.shards);
    const std::string part = shardPath(l, at);
    const ShardRecord& record = files_->record(l, at);
    try {
        if (record.chunks == 0) {
            if (const auto file = openIn(files_->folder(), part, files_->path())) {
                const std::uint64_t bytes = fileSize(*file, files_->shown(l, at));
                throw badFile(files_->shown(l, at), "no file, because zarr.json says that all is fill",
                              std::to_string(bytes) + " bytes");
            }
            return;
        }
        const OpenShard shard = files_->open(l, at);
        std::vector<ShardEntry> entries;
        std::vector<std::uint32_t> crcs(shard.index.size());
        for (std::size_t i = 0; i < shard.index.size(); ++i) {
            const ShardEntry& entry = shard.index[i];
            if (entry.absent())
                continue;
            entries.push_back(entry);
            if (entry.bytes >= kCrcBytes)
                readAt(shard.file, entry.offset + entry.bytes - kCrcBytes,
                       std::as_writable_bytes(std::span(&crcs[i], 1)), shard.shown);
        }
        {
            const std::lock_guard lock(mutex_);
            ++shards_;
            chunks_ += entries.size();
        }
        const std::vector<std::byte> index = encodeIndex(shard.index);
        if (shardRecord(shard.index, crcs, index).payloadCrc != record.payloadCrc)
            level.shards[n] |= kExchanged;
        std::sort(entries.begin(), entries.end(),
                  [](const ShardEntry& a, const ShardEntry& b) { return a.offset < b.offset; });
        std::uint64_t end = 0;
        for (const ShardEntry& entry : entries) {
            if (entry.offset != end)
                throw badFile(shard.shown, "a chunk at offset " + std::to_string(end),
                              "the next one at " + std::to_string(entry.offset));
            end += entry.bytes;
        }
        if (const std::uint64_t bytes = fileSize(shard.file, shard.shown); end + index.size() != bytes)
            throw badFile(shard.shown, std::to_string(end + index.size()) + " bytes", std::to_string(bytes));
    } catch (const BadFile& problem) {
        level.shards[n] |= kBroken;
        faults_.add(part, problem.what());
        if (record.chunks == 0)
            return; // it reads as fill
        const glm::ivec3 first = at * layout.chunks, end = glm::min(first + layout.chunks, level.grid);
        for (int k = first.z; k < end.z; ++k)
            for (int j = first.y; j < end.y; ++j)
                for (int i = first.x; i < end.x; ++i)
                    stateOf({l, i, j, k}) |= kDamaged;
    }
}

/// How levels are made; of names, by how often they occur at level 0.
void StoredLevels::findRule() {
    if (metadata_.rule == kPyramidRule) {
        reduce_ = reduceByTwo;
        return;
    }
    constexpr std::size_t kMostNames = 65536;
    if (valueBytes_ > 2)
        return;
    const Charge charge = ram_.charge(kMostNames * sizeof(std::uint64_t), "counting labels");
    std::vector<std::uint64_t> voxelsOf(kMostNames);
    const Level& level = levels_[0];
    bool isWhole = true;
    parallelFor(level.chunks.size(), static_cast<int>(threads_), [&](std::size_t n) {
        const glm::ivec3 at = gridPosition(n, level.grid);
        const BufferPool::Lease lease(*pool_);
        const Room room = roomOf(lease);
        const bool isRead = readWhole({0, at.x, at.y, at.z}, room, room.raw, false);
        const glm::ivec3 valid = glm::min(level.extent - at * kChunkExtent, glm::ivec3(kChunkExtent));
        const std::lock_guard lock(mutex_);
        isWhole &= isRead;
        if (!isRead)
            return;
        for (int z = 0; z < valid.z; ++z)
            for (int y = 0; y < valid.y; ++y)
                for (int x = 0; x < valid.x; ++x) {
                    std::uint16_t value = 0;
                    std::memcpy(&value,
                                room.raw.data() +
                                    linearIndex({x, y, z}, glm::ivec3(kChunkExtent)) * valueBytes_,
                                valueBytes_);
                    ++voxelsOf[value];
                }
    });
    if (isWhole)
        reduce_ = majorityRule(voxelsOf).reduce;
}

/// Reads a chunk.
/// @param tell  whether damage is a fault; else it is left for the time when the chunk itself is read
bool StoredLevels::readWhole(const ChunkKey& key, const Room& room, std::span<std::byte> out, bool tell) {
    std::uint8_t& state = stateOf(key);
    if (state & kDamaged)
        return false;
    try {
        const std::span<std::byte> encoded = files_->read(key, room.encoded);
        const glm::ivec3 shard = files_->layout(key.level).shardOf(key);
        if (encoded.empty())
            std::copy(fillChunk_.begin(), fillChunk_.end(), out.begin());
        else
            decodeChunk(encoded, out, files_->shown(key.level, shard) + ": " + describe(key),
                        metadata_.codec);
        return true;
    } catch (const InputError& problem) {
        if (tell) {
            state |= kDamaged;
            faults_.add(shardPath(key.level, files_->layout(key.level).shardOf(key)), problem.what());
        }
        return false;
    }
}

/// Puts the chunks that make `coarse` into room.box; at the level after the last, the chunk at its place.
/// @return true if all of them are whole and what they should be
bool StoredLevels::assemble(const ChunkKey& coarse, const Room& room, bool tell) {
    const int l = coarse.level - 1;
    const Level& level = levels_[static_cast<std::size_t>(l)];
    const glm::ivec3 first = 2 * glm::ivec3(coarse.i, coarse.j, coarse.k);
    const glm::ivec3 end = glm::min(first + 2, level.grid);
    const glm::ivec3 extent = glm::min(level.extent - first * kChunkExtent, glm::ivec3(kBoxExtent));
    bool areWhole = true;
    for (int k = first.z; k < end.z; ++k)
        for (int j = first.y; j < end.y; ++j)
            for (int i = first.x; i < end.x; ++i) {
                const ChunkKey key{l, i, j, k};
                const bool isWhole = readWhole(key, room, room.raw, tell);
                areWhole &= isWhole && stateOf(key) == 0;
                if (!isWhole)
                    continue;
                if (tell && l == 0)
                    checkRange(key, room.raw);
                const glm::ivec3 at = (glm::ivec3(i, j, k) - first) * kChunkExtent;
                const glm::ivec3 size = glm::min(extent - at, glm::ivec3(kChunkExtent));
                for (int z = 0; z < size.z; ++z)
                    for (int y = 0; y < size.y; ++y)
                        std::memcpy(
                            room.box.data() + linearIndex(at + glm::ivec3(0, y, z), extent) * valueBytes_,
                            room.raw.data() + linearIndex({0, y, z}, glm::ivec3(kChunkExtent)) * valueBytes_,
                            static_cast<std::size_t>(size.x) * valueBytes_);
            }
    return areWhole;
}

/// Makes a chunk from room.box in room.made.
void StoredLevels::reduce(const ChunkKey& coarse, const Room& room) {
    const glm::ivec3 at(coarse.i, coarse.j, coarse.k);
    const glm::ivec3 fine = glm::min(
        levels_[static_cast<std::size_t>(coarse.level) - 1].extent - at * kBoxExtent, glm::ivec3(kBoxExtent));
    const glm::ivec3 size = ceilDiv(fine, 2);
    // room.raw has place for it: none of its chunks is needed any more.
    const std::span<std::byte> half = room.raw.first(cellCount(size) * valueBytes_);
    reduce_(metadata_.info.type, fine, room.box.first(cellCount(fine) * valueBytes_), half, 1);
    std::copy(fillChunk_.begin(), fillChunk_.end(), room.made.begin());
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            std::memcpy(room.made.data() + linearIndex({0, y, z}, glm::ivec3(kChunkExtent)) * valueBytes_,
                        half.data() + linearIndex({0, y, z}, size) * valueBytes_,
                        static_cast<std::size_t>(size.x) * valueBytes_);
}

/// Reads every chunk of a level, and compares the next one with it.
void StoredLevels::checkLevel(int l, const ShareDone& progress) {
    const bool isLast = l + 1 == kLevelCount;
    const glm::ivec3 grid = isLast ? ceilDiv(levels_[static_cast<std::size_t>(l)].grid, 2)
                                   : levels_[static_cast<std::size_t>(l) + 1].grid;
    parallelFor(
        cellCount(grid), static_cast<int>(threads_),
        [&](std::size_t n) {
            const glm::ivec3 at = gridPosition(n, grid);
            const ChunkKey coarse{l + 1, at.x, at.y, at.z};
            const BufferPool::Lease lease(*pool_);
            const Room room = roomOf(lease);
            if (!assemble(coarse, room, true) || isLast || !reduce_)
                return;
            reduce(coarse, room);
            if (!readWhole(coarse, room, room.raw, false) ||
                std::memcmp(room.made.data(), room.raw.data(), chunkBytes_) == 0)
                return;
            stateOf(coarse) |= kForeign;
            const glm::ivec3 shard = files_->layout(l + 1).shardOf(coarse);
            faults_.add(shardPath(l + 1, shard),
                        badFile(files_->shown(l + 1, shard) + ": " + describe(coarse),
                                "what level " + std::to_string(l) + " gives by the rule of its levels",
                                "other values")
                            .what());
        },
        progress);
}

/// Notes the values of a chunk of level 0.
void StoredLevels::checkRange(const ChunkKey& key, std::span<const std::byte> raw) {
    const glm::ivec3 valid = glm::min(levels_[0].extent - glm::ivec3(key.i, key.j, key.k) * kChunkExtent,
                                      glm::ivec3(kChunkExtent));
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    bool isFinite = true;
    withValueType(metadata_.info.type, [&](auto example) {
        using Value = decltype(example);
        const auto* values = reinterpret_cast<const Value*>(raw.data());
        Value low = values[0], high = values[0];
        for (int z = 0; z < valid.z; ++z)
            for (int y = 0; y < valid.y; ++y) {
                const Value* row = values + linearIndex({0, y, z}, glm::ivec3(kChunkExtent));
                for (int x = 0; x < valid.x; ++x) {
                    low = std::min(low, row[x]);
                    high = std::max(high, row[x]);
                    if constexpr (std::is_floating_point_v<Value>)
                        isFinite = isFinite && std::isfinite(row[x]);
                }
            }
        lowest = static_cast<double>(low);
        highest = static_cast<double>(high);
    });
    if (!isFinite) {
        const glm::ivec3 shard = files_->layout(0).shardOf(key);
        faults_.add(shardPath(0, shard), badFile(files_->shown(0, shard) + ": " + describe(key),
                                                 "finite values", "one that is not")
                                             .what());
    }
    const std::lock_guard lock(mutex_);
    lowest_ = std::min(lowest_, lowest);
    highest_ = std::max(highest_, highest);
}

/// What takes all chunks: exchanged ones, and the range of level 0.
void StoredLevels::finishShards() {
    for (int l = 0; l < kLevelCount; ++l) {
        Level& level = levels_[static_cast<std::size_t>(l)];
        for (std::size_t n = 0; n < level.shards.size(); ++n) {
            if (!(level.shards[n] & kExchanged))
                continue;
            level.shards[n] &= static_cast<std::uint8_t>(~kExchanged);
            const bool isTold = hasFault(l, n);
            level.shards[n] |= kExchanged;
            const glm::ivec3 at = gridPosition(n, files_->layout(l).shards);
            if (!isTold)
                faults_.add(
                    shardPath(l, at),
                    badFile(files_->shown(l, at), "chunks with the checksums of zarr.json", "others").what());
        }
    }
    const Level& finest = levels_[0];
    const bool isWhole = std::all_of(finest.chunks.begin(), finest.chunks.end(),
                                     [](std::uint8_t state) { return state == 0; });
    if (isWhole && (lowest_ != metadata_.lowest || highest_ != metadata_.highest))
        faults_.add(
            "zarr.json",
            badFile((files_->path() / "zarr.json").string(),
                    "the range of level 0, " + numberText(lowest_, 9) + " to " + numberText(highest_, 9),
                    numberText(metadata_.lowest, 9) + " to " + numberText(metadata_.highest, 9))
                .what());
}

bool StoredLevels::hasFault(int l, std::size_t n) const {
    const Level& level = levels_[static_cast<std::size_t>(l)];
    if (level.shards[n] != 0)
        return true;
    const ShardLayout& layout = files_->layout(l);
    const glm::ivec3 first = gridPosition(n, layout.shards) * layout.chunks;
    const glm::ivec3 end = glm::min(first + layout.chunks, level.grid);
    for (int k = first.z; k < end.z; ++k)
        for (int j = first.y; j < end.y; ++j)
            for (int i = first.x; i < end.x; ++i)
                if (level.chunks[linearIndex({i, j, k}, level.grid)] != 0)
                    return true;
    return false;
}

bool StoredLevels::areWhole() const {
    for (int l = 0; l < kLevelCount; ++l)
        for (std::size_t n = 0; n < levels_[static_cast<std::size_t>(l)].shards.size(); ++n)
            if (hasFault(l, n))
                return false;
    return true;
}

} // namespace tessera

// bricking/store/shard_files.cpp: see shard_files.h.
#include "bricking/store/shard_files.h"

#include "bricking/store/codec.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace tessera {

std::size_t largestIndexBytes(const VolumeInfo& info) {
    // Level 0 has the largest shards.
    return shardLayout(info.extentVoxels).indexBytes();
}

ShardFiles::ShardFiles(const std::filesystem::path& path, const StoreMetadata& metadata, MemoryBudget& ram,
                       std::size_t slots)
    : path_(path), folder_(openFolder(path)), metadata_(metadata),
      shards_(ram, slots, largestIndexBytes(metadata.info)) {
    for (int level = 0; level < kLevelCount; ++level)
        layouts_[static_cast<std::size_t>(level)] =
            shardLayout(levelExtent(metadata.info.extentVoxels, level));
}

const ShardRecord& ShardFiles::record(int level, const glm::ivec3& shard) const {
    return metadata_.shards[static_cast<std::size_t>(level)][linearIndex(shard, layout(level).shards)];
}

std::string ShardFiles::shown(int level, const glm::ivec3& shard) const {
    return path_.string() + "/" + shardPath(level, shard);
}

OpenShard ShardFiles::open(int level, const glm::ivec3& at) const {
    const ShardRecord& expected = record(level, at);
    OpenShard shard;
    shard.shown = shown(level, at);
    auto file = openIn(folder_, shardPath(level, at), path_);
    if (!file)
        throw badFile(shard.shown, "a shard with " + std::to_string(expected.chunks) + " chunks",
                      "no such file");
    shard.file = std::move(*file);
    const std::uint64_t bytes = fileSize(shard.file, shard.shown);
    std::vector<std::byte> raw(layout(level).indexBytes());
    if (bytes < raw.size())
        throw badFile(shard.shown, "at least " + std::to_string(raw.size()) + " bytes of index",
                      std::to_string(bytes) + " bytes; the file is cut short");
    readAt(shard.file, bytes - raw.size(), raw, shard.shown);
    shard.index = decodeIndex(raw, bytes - raw.size(), shard.shown);
    const auto written = static_cast<std::uint64_t>(
        std::count_if(shard.index.begin(), shard.index.end(), [](const auto& e) { return !e.absent(); }));
    const std::uint32_t crc = crc32c(std::span(raw).first(raw.size() - kCrcBytes));
    if (written != expected.chunks || crc != expected.indexCrc)
        throw badFile(shard.shown,
                      "the shard that zarr.json describes, with " + std::to_string(expected.chunks) +
                          " chunks",
                      "another index, with " + std::to_string(written) + " chunks");
    return shard;
}

std::optional<RemoteRange> ShardFiles::placeOf(const ChunkKey& key) const {
    const glm::ivec3 at = layout(key.level).shardOf(key);
    if (record(key.level, at).chunks == 0)
        return std::nullopt;
    const ShardTable::Lease shard(shards_, {key.level, at.x, at.y, at.z},
                                  [&] { return open(key.level, at); });
    const ShardEntry& entry = shard->index[layout(key.level).entryOf(key)];
    if (entry.absent())
        return std::nullopt;
    return RemoteRange{shardPath(key.level, at), entry.offset, entry.bytes};
}

std::span<std::byte> ShardFiles::read(const ChunkKey& key, std::span<std::byte> room) const {
    const glm::ivec3 at = layout(key.level).shardOf(key);
    if (record(key.level, at).chunks == 0)
        return {};
    try {
        const ShardTable::Lease shard(shards_, {key.level, at.x, at.y, at.z},
                                      [&] { return open(key.level, at); });
        const ShardEntry& entry = shard->index[layout(key.level).entryOf(key)];
        if (entry.absent())
            return {};
        if (entry.bytes > room.size())
            throw badFile(shard->shown, "at most " + std::to_string(room.size()) + " encoded bytes",
                          std::to_string(entry.bytes));
        const auto encoded = room.first(static_cast<std::size_t>(entry.bytes));
        readAt(shard->file, entry.offset, encoded, shard->shown);
        if (encoded.empty()) // what is left out has no entry
            throw badFile(shard->shown, "a blosc header and a checksum", "0 bytes");
        return encoded;
    } catch (const InputError& problem) {
        throw InputError(std::string(problem.what()) + " (" + describe(key) + ")");
    }
}

} // namespace tessera

// bricking/store/store_reader.cpp: see store_reader.h.
#include "bricking/store/store_reader.h"

#include "bricking/store/buffer_pool.h"
#include "bricking/store/codec.h"
#include "bricking/store/shard.h"
#include "bricking/store/store_files.h"
#include "bricking/store/zarr_metadata.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace tessera {
namespace {

/// Memory a reader of this store would like: every shard open, a decode buffer per processor.
struct Appetite {
    std::size_t shards = 0, indexBytes = 0, buffers = 0, bufferBytes = 0;
};
std::size_t largestIndexBytes(const VolumeInfo& info) {
    // Level 0 has the largest shards.
    return shardLayout(info.extentVoxels).indexBytes();
}
std::size_t bufferBytes(const VolumeInfo& info) {
    return encodedBound(cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info.type));
}
Appetite appetiteOf(const StoreMetadata& metadata, const MemoryBudget& ram) {
    Appetite wanted;
    for (const auto& level : metadata.shards)
        for (const ShardRecord& record : level)
            wanted.shards += record.chunks > 0;
    wanted.indexBytes = largestIndexBytes(metadata.info);
    wanted.bufferBytes = bufferBytes(metadata.info);
    const std::size_t share = ram.freeBytes() / 8; // a quarter for both, but at least one of each
    wanted.shards =
        std::clamp<std::size_t>(std::min(wanted.shards, share / wanted.indexBytes), 1, ShardTable::kMaxSlots);
    wanted.buffers =
        std::clamp<std::size_t>(share / wanted.bufferBytes, 1, static_cast<std::size_t>(defaultThreads()));
    return wanted;
}

StoreMetadata readMetadata(const FileHandle& folder, const std::filesystem::path& path) {
    const auto document = [&](const std::string& relative) {
        const auto text = readText(folder, relative, path, kMaxMetadataBytes);
        if (!text)
            throw badFile((path / relative).string(), "the metadata of a store", "no such file");
        return *text;
    };
    StoreMetadata metadata = parseGroup(document("zarr.json"), (path / "zarr.json").string());
    for (int level = 0; level < kLevelCount; ++level) {
        const std::string relative = std::to_string(level) + "/zarr.json";
        checkLevel(document(relative), metadata.info, level, (path / relative).string());
    }
    return metadata;
}

} // namespace

struct StoreReader::State {
    State(const std::filesystem::path& folderPath, MemoryBudget& ram)
        : path(folderPath), folder(openFolder(path)), metadata(readMetadata(folder, path)),
          appetite(appetiteOf(metadata, ram)), shards(ram, appetite.shards, appetite.indexBytes),
          buffers(ram, appetite.buffers, appetite.bufferBytes, "reading a store") {
        for (int level = 0; level < kLevelCount; ++level)
            layouts[static_cast<std::size_t>(level)] =
                shardLayout(levelExtent(metadata.info.extentVoxels, level));
    }

    OpenShard openShard(int level, const glm::ivec3& at, const ShardRecord& record) const;

    std::filesystem::path path;
    FileHandle folder;
    StoreMetadata metadata;
    Appetite appetite;
    ShardTable shards;
    BufferPool buffers;
    std::array<ShardLayout, kLevelCount> layouts;
};

OpenShard StoreReader::State::openShard(int level, const glm::ivec3& at, const ShardRecord& record) const {
    const std::string relative = shardPath(level, at);
    const ShardLayout& layout = layouts[static_cast<std::size_t>(level)];
    OpenShard shard;
    shard.shown = (path / relative).string();
    auto file = openIn(folder, relative, path);
    if (!file)
        throw badFile(shard.shown, "a shard with " + std::to_string(record.chunks) + " chunks",
                      "no such file");
    shard.file = std::move(*file);
    const std::uint64_t bytes = fileSize(shard.file, shard.shown);
    if (bytes < layout.indexBytes())
        throw badFile(shard.shown, "at least " + std::to_string(layout.indexBytes()) + " bytes of index",
                      std::to_string(bytes) + " bytes; the file is cut short");
    std::vector<std::byte> raw(layout.indexBytes());
    readAt(shard.file, bytes - raw.size(), raw, shard.shown);
    shard.index = decodeIndex(raw, bytes - raw.size(), shard.shown);
    const auto written = static_cast<std::uint64_t>(
        std::count_if(shard.index.begin(), shard.index.end(), [](const auto& e) { return !e.absent(); }));
    const std::uint32_t crc = crc32c(std::span(raw).first(raw.size() - kCrcBytes));
    if (written != record.chunks || crc != record.indexCrc)
        throw badFile(shard.shown,
                      "the shard that zarr.json describes, with " + std::to_string(record.chunks) + " chunks",
                      "another index, with " + std::to_string(written) + " chunks");
    return shard;
}

StoreReader::StoreReader(const std::filesystem::path& path, MemoryBudget& ram, const glm::dmat4& moved)
    : state_(std::make_unique<State>(path, ram)) {
    glm::dmat4& placed = state_->metadata.info.patientFromVoxel;
    placed = moved * placed;
}
StoreReader::~StoreReader() = default;

const std::filesystem::path& StoreReader::path() const {
    return state_->path;
}
const VolumeInfo& StoreReader::info() const {
    return state_->metadata.info;
}

void StoreReader::readChunk(const ChunkKey& key, std::span<std::byte> out) const {
    TESSERA_CHECK(key.level >= 0 && key.level < kLevelCount && out.size() == chunkBytes());
    const glm::ivec3 grid = chunkGrid(info().extentVoxels, key.level);
    TESSERA_CHECK(key.i >= 0 && key.j >= 0 && key.k >= 0 && key.i < grid.x && key.j < grid.y &&
                  key.k < grid.z);

    const ShardLayout& layout = state_->layouts[static_cast<std::size_t>(key.level)];
    const glm::ivec3 at = layout.shardOf(key);
    const ShardRecord& record =
        state_->metadata.shards[static_cast<std::size_t>(key.level)][linearIndex(at, layout.shards)];
    if (record.chunks > 0) {
        const BufferPool::Lease buffer(state_->buffers);
        bool found = false;
        std::span<std::byte> encoded;
        std::string where;
        try {
            const ShardTable::Lease shard(state_->shards, {key.level, at.x, at.y, at.z},
                                          [&] { return state_->openShard(key.level, at, record); });
            const ShardEntry& entry = shard->index[layout.entryOf(key)];
            where = shard->shown;
            if (!entry.absent()) {
                if (entry.bytes > buffer.bytes().size())
                    throw badFile(where,
                                  "at most " + std::to_string(buffer.bytes().size()) + " encoded bytes",
                                  std::to_string(entry.bytes));
                encoded = buffer.bytes().first(static_cast<std::size_t>(entry.bytes));
                readAt(shard->file, entry.offset, encoded, where);
                found = true;
            }
        } catch (const InputError& problem) {
            throw InputError(std::string(problem.what()) + " (" + describe(key) + ")");
        }
        if (found)
            return decodeChunk(encoded, out, where + ": " + describe(key));
    }
    std::byte fill[8];
    const std::size_t valueBytes = bytesPerValue(info().type);
    storeFill(info(), fill);
    for (std::size_t i = 0; i < out.size(); i += valueBytes)
        std::memcpy(out.data() + i, fill, valueBytes);
}

std::string StoreReader::contentHash() const {
    return contentHashOf(state_->metadata);
}

std::size_t readerFloorBytes(const VolumeInfo& info) {
    return largestIndexBytes(info) + bufferBytes(info);
}

bool isStore(const std::filesystem::path& path) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path / "zarr.json", ignored))
        return false;
    try {
        const auto text = readText(openFolder(path), "zarr.json", path, kMaxMetadataBytes);
        return text && isGroupOfOurs(*text);
    } catch (const InputError&) {
        return false;
    }
}

} // namespace tessera

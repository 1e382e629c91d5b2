// bricking/store/store_reader.cpp: see store_reader.h.
#include "bricking/store/store_reader.h"

#include "bricking/store/buffer_pool.h"
#include "bricking/store/codec.h"
#include "bricking/store/shard_files.h"
#include "bricking/store/store_files.h"
#include "bricking/store/zarr_metadata.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace tessera {
namespace {

/// Memory a reader of this store would like: every shard open, a decode buffer per processor.
struct Appetite {
    std::size_t shards = 0, indexBytes = 0, buffers = 0, bufferBytes = 0;
};
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

StoreMetadata readMetadata(const std::filesystem::path& path) {
    const FileHandle folder = openFolder(path);
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
    State(const std::filesystem::path& path, StoreMetadata read, MemoryBudget& ram)
        : metadata(std::move(read)), appetite(appetiteOf(metadata, ram)),
          shards(path, metadata, ram, appetite.shards),
          buffers(ram, appetite.buffers, appetite.bufferBytes, "reading a store") {}

    StoreMetadata metadata;
    Appetite appetite;
    ShardFiles shards;
    BufferPool buffers;
};

StoreReader::StoreReader(const std::filesystem::path& path, MemoryBudget& ram, const glm::dmat4& moved)
    : state_(std::make_unique<State>(path, readMetadata(path), ram)) {
    glm::dmat4& placed = state_->metadata.info.patientFromVoxel;
    placed = moved * placed;
}
StoreReader::~StoreReader() = default;

const std::filesystem::path& StoreReader::path() const {
    return state_->shards.path();
}
const VolumeInfo& StoreReader::info() const {
    return state_->metadata.info;
}

void StoreReader::readChunk(const ChunkKey& key, std::span<std::byte> out) const {
    TESSERA_CHECK(key.level >= 0 && key.level < kLevelCount && out.size() == chunkBytes());
    const glm::ivec3 grid = chunkGrid(info().extentVoxels, key.level);
    TESSERA_CHECK(key.i >= 0 && key.j >= 0 && key.k >= 0 && key.i < grid.x && key.j < grid.y &&
                  key.k < grid.z);

    {
        const BufferPool::Lease buffer(state_->buffers);
        const std::span<std::byte> encoded = state_->shards.read(key, buffer.bytes());
        if (!encoded.empty()) {
            const glm::ivec3 shard = state_->shards.layout(key.level).shardOf(key);
            return decodeChunk(encoded, out, state_->shards.shown(key.level, shard) + ": " + describe(key));
        }
    }
    fillWith(info(), out);
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

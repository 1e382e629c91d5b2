// bricking/store/store_reader.cpp: see store_reader.h.
#include "bricking/store/store_reader.h"

#include "bricking/store/buffer_pool.h"
#include "bricking/store/codec.h"
#include "bricking/store/shard_files.h"
#include "bricking/store/store_files.h"
#include "bricking/store/zarr_metadata.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr int kIndicesAtOnce = 8;

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
    const StoreFolder folder = openFolder(path);
    const auto document = [&](const std::string& relative) {
        const auto text = readText(folder, relative, path, kMaxMetadataBytes);
        if (!text)
            throw badFile((path / relative).string(), "the metadata of a store", "no such file");
        return *text;
    };
    if (folder.remote) {
        std::vector<RemoteRange> ranges = {{folder.remote->nameOf("stats/zarr.json")}};
        for (int level = 0; level < kLevelCount; ++level)
            ranges.push_back({folder.remote->nameOf(std::to_string(level) + "/zarr.json")});
        folder.remote->files->willRead(std::move(ranges));
    }
    StoreMetadata metadata = parseGroup(document("zarr.json"), (path / "zarr.json").string());
    for (int level = 0; level < kLevelCount; ++level) {
        const std::string relative = std::to_string(level) + "/zarr.json";
        checkLevel(document(relative), metadata, level, (path / relative).string());
    }
    return metadata;
}

} // namespace

struct StoreReader::State {
    State(const std::filesystem::path& path, StoreMetadata read, MemoryBudget& ram)
        : metadata(std::move(read)), remote(remotePlaceOf(path)),
          inFlight(ram.charge(remote ? remote->files->bytesInFlight() : 0, "fetching " + path.string())),
          appetite(appetiteOf(metadata, ram)), shards(path, metadata, ram, appetite.shards),
          buffers(ram, appetite.buffers, appetite.bufferBytes, "reading a store") {}

    StoreMetadata metadata;
    std::optional<RemotePlace> remote;
    Charge inFlight;
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

std::pair<double, double> StoreReader::storedRange() const {
    return {state_->metadata.lowest, state_->metadata.highest};
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
            return decodeChunk(encoded, out, state_->shards.shown(key.level, shard) + ": " + describe(key),
                               state_->metadata.codec);
        }
    }
    fillWith(info(), out);
}

void StoreReader::willRead(std::span<const ChunkKey> keys) const {
    if (!state_->remote)
        return;
    // The indices of their shards are fetched side by side: each takes the time of two answers.
    std::map<std::tuple<int, int, int, int>, std::size_t> numbers;
    std::vector<ChunkKey> firsts;
    std::vector<std::size_t> shardOf;
    for (const ChunkKey& key : keys) {
        const glm::ivec3 at = state_->shards.layout(key.level).shardOf(key);
        const auto [number, isNew] = numbers.try_emplace({key.level, at.x, at.y, at.z}, firsts.size());
        if (isNew)
            firsts.push_back(key);
        shardOf.push_back(number->second);
    }
    std::vector<char> isOutOfReach(firsts.size());
    const auto placeOf = [&](const ChunkKey& key, std::size_t shard) -> std::optional<RemoteRange> {
        try {
            return state_->shards.placeOf(key);
        } catch (const InputError&) { // told when the chunk is read
            isOutOfReach[shard] = 1;
            return std::nullopt;
        }
    };
    parallelFor(firsts.size(), kIndicesAtOnce, [&](std::size_t i) { placeOf(firsts[i], i); });
    std::vector<RemoteRange> ranges;
    for (std::size_t i = 0; i < keys.size(); ++i)
        if (!isOutOfReach[shardOf[i]])
            if (const std::optional<RemoteRange> range = placeOf(keys[i], shardOf[i]))
                ranges.push_back({state_->remote->nameOf(range->name), range->offset, range->bytes});
    state_->remote->files->willRead(std::move(ranges));
}

std::string StoreReader::contentHash() const {
    return contentHashOf(state_->metadata);
}

std::optional<RemoteFiles::Counters> fetchedFor(Stores stores) {
    std::set<const RemoteFiles*> seen; // stores may lie behind one address
    RemoteFiles::Counters all;
    for (const StoreReader* store : stores) {
        const std::optional<RemotePlace> place = remotePlaceOf(store->path());
        if (!place || !seen.insert(place->files.get()).second)
            continue;
        const RemoteFiles::Counters one = place->files->counters();
        all.requests += one.requests;
        all.retries += one.retries;
        all.bytesFetched += one.bytesFetched;
        all.bytesFromDisk += one.bytesFromDisk;
    }
    return seen.empty() ? std::nullopt : std::optional(all);
}

std::size_t readerFloorBytes(const VolumeInfo& info) {
    return largestIndexBytes(info) + bufferBytes(info);
}

bool isStore(const std::filesystem::path& path) {
    std::error_code ignored;
    if (!isAddress(path) && !std::filesystem::is_regular_file(path / "zarr.json", ignored))
        return false;
    try {
        const auto text = readText(openFolder(path), "zarr.json", path, kMaxMetadataBytes);
        return text && isGroupOfOurs(*text);
    } catch (const InputError&) {
        return false;
    }
}

} // namespace tessera

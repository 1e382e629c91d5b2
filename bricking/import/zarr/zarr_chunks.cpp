// bricking/import/zarr/zarr_chunks.cpp: see zarr_chunks.h.
#include "bricking/import/zarr/zarr_chunks.h"

#include "bricking/import/zarr/decompress.h"
#include "bricking/store/codec.h"
#include "core/base/error.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kIndicesBytes = std::size_t{4} << 20; // of open shards; at least one
constexpr std::size_t kMostShards = 64;

std::uint64_t chunksOfShard(const ZarrArray& array) {
    std::uint64_t all = 1;
    for (const std::int64_t count : array.shard)
        all *= static_cast<std::uint64_t>(count);
    return all;
}

std::size_t indexBytesOf(const ZarrArray& array) {
    return static_cast<std::size_t>(chunksOfShard(array)) * sizeof(ShardEntry) + kCrcBytes;
}

std::size_t openShardsOf(const ZarrArray& array) {
    return std::clamp<std::size_t>(kIndicesBytes / indexBytesOf(array), 1, kMostShards);
}

std::string textOf(std::span<const std::int64_t> at) {
    std::string text;
    for (const std::int64_t i : at)
        text += (text.empty() ? "" : ",") + std::to_string(i);
    return "chunk (" + text + ")";
}

} // namespace

ZarrChunks::ZarrChunks(const ZarrArray& array) : array_(array), folder_(*array.folder) {}

std::size_t ZarrChunks::bytesNeeded(const ZarrArray& array) {
    const std::size_t indices = array.shard.empty() ? 0 : 2 * indexBytesOf(array) * (openShardsOf(array) + 1);
    return array.chunkBytes() + array.encodedBound() + indices;
}

std::string ZarrChunks::fileOf(const ZarrArray& array, std::span<const std::int64_t> at) {
    std::string key = array.prefix;
    for (std::size_t axis = 0; axis < at.size(); ++axis)
        key += (axis == 0 ? "" : array.separator) + std::to_string(at[axis]);
    return key;
}

void ZarrChunks::countMissing(std::string file) {
    if (tally_.missing++ == 0)
        tally_.firstMissing = std::move(file);
}

std::span<const std::byte> ZarrChunks::fetched(const StoreFile& file, std::uint64_t offset,
                                               std::uint64_t bytes) {
    if (bytes > array_.encodedBound())
        throw badFile(where_, "at most " + std::to_string(array_.encodedBound()) + " bytes of a chunk",
                      std::to_string(bytes));
    encoded_.resize(static_cast<std::size_t>(bytes));
    readAt(file, offset, encoded_, where_);
    return encoded_;
}

std::span<const std::byte> ZarrChunks::encodedFile(std::span<const std::int64_t> at) {
    const std::string key = fileOf(array_, at);
    where_ = (array_.path / key).string();
    const auto file = openIn(folder_, key, array_.path);
    if (!file) {
        countMissing(key);
        return {};
    }
    const std::uint64_t bytes = fileSize(*file, where_);
    if (bytes == 0)
        throw badFile(where_, "a chunk", "an empty file");
    return fetched(*file, 0, bytes);
}

/// Null: there is no such file.
const OpenShard* ZarrChunks::shardOf(const std::vector<std::int64_t>& at) {
    auto found = shards_.find(at);
    if (found == shards_.end()) {
        if (shards_.size() >= openShardsOf(array_))
            shards_.erase(shards_.begin()); // places ascend
        const std::string key = fileOf(array_, at);
        OpenShard shard;
        shard.shown = (array_.path / key).string();
        if (auto file = openIn(folder_, key, array_.path)) {
            const std::uint64_t bytes = fileSize(*file, shard.shown);
            const std::size_t indexBytes = indexBytesOf(array_);
            if (bytes < indexBytes)
                throw badFile(shard.shown, "at least " + std::to_string(indexBytes) + " bytes of index",
                              std::to_string(bytes) + " bytes; the file is cut short");
            std::vector<std::byte> raw(indexBytes);
            readAt(*file, array_.isIndexInFront ? 0 : bytes - indexBytes, raw, shard.shown);
            shard.index = decodeIndex(raw, array_.isIndexInFront ? bytes : bytes - indexBytes, shard.shown);
            shard.file = std::move(*file);
        }
        found = shards_.emplace(at, std::move(shard)).first;
    }
    return found->second.index.empty() ? nullptr : &found->second;
}

std::span<const std::byte> ZarrChunks::ofShard(std::span<const std::int64_t> at) {
    std::vector<std::int64_t> place;
    std::uint64_t entry = 0;
    for (std::size_t axis = 0; axis < at.size(); ++axis) {
        place.push_back(at[axis] / array_.shard[axis]);
        entry = entry * static_cast<std::uint64_t>(array_.shard[axis]) +
                static_cast<std::uint64_t>(at[axis] % array_.shard[axis]);
    }
    const OpenShard* const shard = shardOf(place);
    if (!shard)
        countMissing(fileOf(array_, place));
    if (!shard || shard->index[entry].absent())
        return {};
    where_ = shard->shown + ": " + textOf(at);
    if (shard->index[entry].bytes == 0)
        throw badFile(where_, "a chunk", "0 bytes");
    return fetched(shard->file, shard->index[entry].offset, shard->index[entry].bytes);
}

std::span<const std::byte> ZarrChunks::decoded(std::span<const std::byte> bytes) {
    const std::size_t whole = array_.chunkBytes();
    for (std::size_t i = array_.codecs.size(); i-- > 0;) {
        if (array_.codecs[i] == ZarrCodec::crc32c)
            bytes = withoutCrc(bytes, where_);
        else {
            requireChunkSize(array_.codecs[i], bytes, whole, where_);
            decoded_.resize(whole);
            decompress(array_.codecs[i], bytes, decoded_, where_);
            bytes = decoded_;
        }
    }
    if (bytes.size() != whole)
        throw badFile(where_, std::to_string(whole) + " bytes of values", std::to_string(bytes.size()));
    return bytes;
}

void ZarrChunks::tell(const std::vector<std::vector<std::int64_t>>& places) const {
    if (!isToBeTold())
        return;
    std::vector<RemoteRange> ranges;
    ranges.reserve(places.size());
    for (const std::vector<std::int64_t>& at : places)
        ranges.push_back({folder_.remote->nameOf(fileOf(array_, at)), 0, array_.encodedBound()});
    folder_.remote->files->willRead(std::move(ranges));
}

std::span<const std::byte> ZarrChunks::read(std::span<const std::int64_t> at) {
    ++tally_.read;
    const auto encoded = array_.shard.empty() ? encodedFile(at) : ofShard(at);
    return encoded.empty() ? encoded : decoded(encoded);
}

void findSeparator(ZarrArray& array) {
    if (array.isSeparatorSaid || array.shape.size() < 2)
        return;
    const StoreFolder& folder = *array.folder;
    for (const std::int64_t half : {1, 0, 2}) {
        std::vector<std::int64_t> at;
        for (std::size_t axis = 0; axis < array.shape.size(); ++axis)
            at.push_back((array.shape[axis] - 1) / array.chunk[axis] * half / 2);
        for (const char* separator : {".", "/"}) {
            array.separator = separator;
            const std::string file = ZarrChunks::fileOf(array, at);
            if (!openIn(folder, file, array.path))
                continue;
            if (array.separator == "/")
                array.notes.push_back("chunks are taken by names such as " + file +
                                      ", which the metadata do not say");
            return;
        }
    }
    array.separator = ".";
}

} // namespace tessera

// bricking/import/zarr/zarr_array.h: ZarrArray: what the metadata of an array of numbers say, for both
// versions of Zarr: shape, chunks, shards, type, order of bytes and compression.
#pragma once

#include "bricking/import/source/slice_converter.h" // FileType
#include "bricking/import/zarr/zarr_node.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// From bytes to bytes, in the words of Zarr v3. zlib and lz4 are of version 2 alone.
enum class ZarrCodec : std::uint8_t { blosc, zstd, gzip, zlib, lz4, crc32c };

struct ZarrArray {
    static constexpr std::size_t kMostAxes = 8;
    static constexpr std::int64_t kMostAlong = 1 << 30;                      // elements along an axis
    static constexpr std::uint64_t kMostChunkBytes = std::uint64_t{1} << 30; // decoded
    static constexpr std::uint64_t kMostChunksOfShard = std::uint64_t{1}
                                                        << 24; // its index has 16 bytes for each

    std::filesystem::path path;
    std::shared_ptr<const StoreFolder> folder; // that path, open
    std::string where;                         // its metadata, for messages
    /// Elements, slowest axis first; the three have one length, 1 to kMostAxes.
    std::vector<std::int64_t> shape,
        chunk;                       // chunk: that is compressed as one, which a shard holds several of
    std::vector<std::int64_t> shard; // chunks of a shard; empty: files are chunks
    bool isIndexInFront = false;     // of a shard
    FileType type = FileType::u8;    // bool: u8
    bool bigEndian = false;
    std::vector<std::size_t> order;          // the axes of a chunk's bytes, slowest first
    std::vector<ZarrCodec> codecs;           // in the order of encoding; at most one of them compresses
    std::array<std::byte, 8> fill{};         // a value as chunks have it
    std::string fillShown;                   // the same for messages
    std::string prefix, separator;           // of the names of files: "c/" and "/"
    bool isSeparatorSaid = true;             // else "." may be wrong: findSeparator()
    std::vector<std::string> dimensionNames; // "" for none; empty: none at all
    std::vector<std::string> notes;          // findings that a user should know, one a line

    std::size_t valueBytes() const { return bytesPerFileValue(type); }
    std::size_t chunkBytes() const;
    /// Most bytes of a chunk in its file: no codec adds more.
    std::size_t encodedBound() const { return chunkBytes() + chunkBytes() / 8 + (std::size_t{64} << 10); }
};

/// Throws InputError naming the file and the key for what is missing, out of range, or not read: other types,
/// chunk grids, codecs and filters are named.
ZarrArray zarrArrayOf(const ZarrNode& node);

} // namespace tessera

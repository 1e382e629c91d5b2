// bricking/store/zarr_metadata.h: the JSON documents of a store, generated from and checked against one
// description. In OME-Zarr 0.5 the group's zarr.json holds attributes.ome (for other readers) and
// attributes.tessera (complete: affine, rescale, counts). Reading parses attributes.tessera, generates the
// documents from it again and requires equality. So every field for other readers is known to be correct.
// Layout: bricking/README.md.
#pragma once

#include "bricking/store/codec.h"
#include "core/base/brick.h"
#include "core/base/volume.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

constexpr int kStoreVersion = 1;
constexpr std::uint64_t kMaxMetadataBytes = 16u << 20; // 500 000 shards, 500 TB of int16

/// The metadata of one shard, which distinguishes a lost or exchanged file from an empty one.
struct ShardRecord {
    std::uint32_t chunks = 0;     // chunks written; 0: the file does not exist, all is fill
    std::uint32_t indexCrc = 0;   // CRC-32C of the index as stored, without its own checksum
    std::uint32_t payloadCrc = 0; // CRC-32C over the CRCs of the written chunks, in index order
};

struct StoreMetadata {
    VolumeInfo info;
    double lowest = 0, highest = 0; // stored values of level 0
    Codec codec = Codec::lz4;       // of chunks; told only where it is another
    std::string rule;               // kPyramidRule or kMajorityRule
    std::string imageLabel;         // JSON of OME's "image-label": colours and properties of labels; "" none
    std::array<std::vector<ShardRecord>, kLevelCount> shards; // per level [z][y][x] of the shard grid
};

/// Throws InputError naming where if info cannot be stored: validate() fails, or fillStored does not fit its
/// type.
void checkStorable(const VolumeInfo& info, const std::string& where);
/// info with its texts cut to 64 printable ASCII characters, as in a store; a frame of reference that is no
/// UID is none.
VolumeInfo withPlainTexts(VolumeInfo info);

/// zarr.json of the group, with a CRC-32C over itself in attributes.tessera.checksum.
std::string groupDocument(const StoreMetadata& metadata);
/// zarr.json of the array of one level.
std::string levelDocument(const StoreMetadata& metadata, int level);

/// Throws InputError that begins with where and names the first key that is wrong.
StoreMetadata parseGroup(std::string_view text, const std::string& where);
void checkLevel(std::string_view text, const StoreMetadata& metadata, int level, const std::string& where);
/// True if text is JSON with attributes.tessera; nothing else is checked.
bool isGroupOfOurs(std::string_view text);
/// True of the text of a zarr.json unless it is another program's: also of a store that is damaged, for which
/// the reader says what is wrong.
bool couldBeOurs(std::string_view text);
/// 16 hex digits over the canonical group document, which holds the CRCs of all shards and chunks, without
/// remarks and frame of reference.
std::string contentHashOf(const StoreMetadata& metadata);

} // namespace tessera

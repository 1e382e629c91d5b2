// render/residency/pages.h: arithmetic of pages: the pages that bricks take, the box of pages that a texture
// can be, and a brick's samples in the cache. Nothing here knows a device.
#pragma once

#include "bricking/cache/brick_cache.h" // ChunkKey
#include "core/base/brick.h"
#include "core/base/volume.h"

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>

namespace tessera {

/// What an engine's memory of bricks may be: of GPU textures from the context, or assumed where
/// there is none.
struct TextureLimits {
    int maxExtent = 2048; // texels, a page's edge counted as 32
    std::size_t maxBytes = std::size_t{1} << 30;
    int pageEdge = kBrickExtent;     // samples that a page has room for along an axis, ghost layers included
    bool readsOnce = false;          // chunks are read when bricks are put there, and not again
    int lightChannels = 0;           // of the scene: planes of 16 bits a sample beside the values
    std::size_t indexEntryBytes = 8; // of every brick, in each plane: where it is, or what it stands for
};

/// Pages that bricks take, from their number per level. The coarsest level takes none: its one sample stands
/// in the index, as an empty brick's mean does.
std::size_t pagesFor(const std::array<std::size_t, kLevelCount + 1>& counts);
/// Smallest box that holds so many pages; 0 along x when none can.
glm::ivec3 atlasPages(std::size_t pages, ValueType type, const TextureLimits& limits);
/// Bytes of that box; the largest size_t when none can.
std::size_t atlasBytes(std::size_t pages, ValueType type, const TextureLimits& limits);
/// Most pages whose box fits; 0: not even one.
std::size_t pagesThatFit(std::size_t bytes, ValueType type, const TextureLimits& limits);

/// The chunk that holds a brick at a level: a chunk has 2^level bricks per edge.
ChunkKey chunkOf(std::size_t brick, int level, const glm::ivec3& bricks);

/// Bytes of the index: where every brick is, or what it stands for.
constexpr std::size_t kIndexEntryBytes = TextureLimits{}.indexEntryBytes;
inline std::size_t indexBytes(const glm::ivec3& bricks, std::size_t entryBytes = kIndexEntryBytes) {
    return entryBytes * cellCount(bricks);
}
/// RAM that loading bricks takes besides the cache: one brick as texels, the index, levels, and the driver's
/// copy of the index.
std::size_t stagingBytes(const VolumeInfo& info);

} // namespace tessera

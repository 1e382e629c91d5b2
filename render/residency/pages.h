// render/residency/pages.h: arithmetic of pages: the pages of bricks, the box of pages in a texture, and a
// brick's samples in the cache. It needs no device.
#pragma once

#include "bricking/cache/brick_cache.h" // ChunkKey
#include "core/base/brick.h"
#include "core/base/volume.h"

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

namespace tessera {

// Allocates bricks' slots in the atlas. Pages of 32^3 texels are each divided into slots of one level. Every
// plane of the atlas shares the same slots.

/// A brick's slot: page in units of pages, slot in units of (32 >> level) texels inside the page.
struct AtlasSlot {
    glm::ivec3 page{0}, slot{0};
    int level = 0;
    glm::ivec3 originTexels() const { return page * kBrickExtent + slot * (kBrickExtent >> level); }
};

/// Allocates slots of any level; a page holds one level at a time and returns to the pool when it is empty.
class PageAllocator {
  public:
    explicit PageAllocator(const glm::ivec3& pages);
    /// Nullopt if no page is left.
    std::optional<AtlasSlot> allocate(int level);
    void release(const AtlasSlot& slot);
    std::size_t freePages() const { return freePages_.size(); }

    static int slotsPerEdge(int level) { return 1 << level; }
    static std::size_t slotsPerPage(int level) { return std::size_t{1} << (3 * level); }
    /// Pages for `bricks` bricks of one level.
    static std::size_t pagesFor(std::size_t bricks, int level) {
        return (bricks + slotsPerPage(level) - 1) / slotsPerPage(level);
    }

  private:
    struct Page {
        int level = -1; // -1: free
        std::size_t used = 0;
        std::vector<std::uint16_t> freeSlots; // kept only while the page is in use
    };
    glm::ivec3 pages_;
    std::vector<Page> page_;
    std::vector<std::size_t> freePages_;               // a stack
    std::vector<std::vector<std::size_t>> partlyUsed_; // per level: pages with a free slot
};

/// Limits of an engine's brick memory: of GPU textures from the context, or assumed without one.
struct TextureLimits {
    int maxExtent = 2048; // texels, a page's edge counted as 32
    std::size_t maxBytes = std::size_t{1} << 30;
    int pageEdge = kBrickExtent;     // samples of a page along an axis, ghost layers included
    bool readsOnce = false;          // chunks are read only when bricks are put
    int channelsBeside = 0;          // of the scene: planes of 16 bits a sample beside the values
    std::size_t indexEntryBytes = 8; // entry per brick, in each plane: slot, or value
};

/// Pages of bricks, from their number per level. The coarsest level needs none: its one sample is in the
/// index, like an empty brick's mean.
std::size_t pagesFor(const std::array<std::size_t, kLevelCount + 1>& counts);
/// Smallest box for a number of pages; 0 along x if there is none.
glm::ivec3 atlasPages(std::size_t pages, ValueType type, const TextureLimits& limits);
/// Bytes of that box; the largest size_t if there is none.
std::size_t atlasBytes(std::size_t pages, ValueType type, const TextureLimits& limits);
/// Largest number of pages whose box fits; 0: not even one.
std::size_t pagesThatFit(std::size_t bytes, ValueType type, const TextureLimits& limits);

/// The chunk that holds a brick at a level: a chunk has 2^level bricks per edge.
ChunkKey chunkOf(std::size_t brick, int level, const glm::ivec3& bricks);

/// Bytes of the index: the slot or value of every brick.
constexpr std::size_t kIndexEntryBytes = TextureLimits{}.indexEntryBytes;
inline std::size_t indexBytes(const glm::ivec3& bricks, std::size_t entryBytes = kIndexEntryBytes) {
    return entryBytes * cellCount(bricks);
}
/// RAM for loading bricks, without the cache: one brick as texels, the index, levels, and the driver's copy
/// of the index.
std::size_t stagingBytes(const VolumeInfo& info);

} // namespace tessera

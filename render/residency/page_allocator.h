// render/residency/page_allocator.h: allocates bricks' slots in the atlas. Pages of 32^3 texels are each
// divided into slots of one level. Every plane of the atlas shares the same slots.
#pragma once

#include "core/base/brick.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

namespace tessera {

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

} // namespace tessera

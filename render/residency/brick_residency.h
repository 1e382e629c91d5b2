// render/residency/brick_residency.h: the residency of bricks. Pages of 32^3 samples are cut into slots of
// one level (page_allocator.h). Every brick has an entry that says where it is, or what value it stands for.
// It is CPU only: planes hold the bricks' data, in GL or in host memory (plane.h).
//
// An entry (two 32-bit words):
//   resident: x = page.x | page.y << 10 | page.z << 20, y = slot.x | slot.y << 5 | slot.z << 10
//   value:    x = 0x80000000,                           y = bits of its mean (float, stored units):
//             an empty brick, or one of the coarsest level
//   absent:   x = 0x40000000: wanted, not here yet
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/levels/selection.h"
#include "core/base/budget.h"
#include "core/base/work.h"
#include "render/residency/page_allocator.h"
#include "render/residency/pages.h"
#include "render/residency/plane.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

/// A brick at a level below the coarsest, and the chunk that holds it.
struct BrickToPlace {
    std::size_t brick = 0;
    int level = 0;
    ChunkPointer chunk;
};

class BrickResidency {
  public:
    /// Nothing is resident: every brick that has samples of its own is absent.
    /// @param planes  hold what is placed; each has room for boxOf(pages); they outlive this
    /// @param pages   at least 1; may be fewer than the selection takes, where rays wait (kFeaturePasses)
    BrickResidency(const VolumeInfo& info, const Selection& selection, std::size_t pages,
                   const TextureLimits& limits, std::vector<Plane*> planes, MemoryBudget& ram);

    /// One picture. load() brings every brick of the selection through the cache, batch by batch; adopt()
    /// takes another selection, keeping what it has in common with the last. Both publish the entries.
    void load(BrickCache& cache, Work& work);
    void adopt(const Selection& selection);
    /// Makes the given bricks resident, evicting others where there is no room, and publishes the entries.
    /// @param bricks  numbers in the brick grid, each once; must fit into the pages together
    void serve(std::span<const std::size_t> bricks, BrickCache& cache, Work& work);

    /// Pictures that follow one another: bricks move one by one, each standing as its mean while it has no
    /// samples here. Places them at their levels, each in the stead of what it was, until there is no room;
    /// returns how many. publish() must follow before rays are drawn.
    std::size_t place(std::span<const BrickToPlace> bricks, Work& work);
    /// The brick stands as its mean, and gives its room back.
    void dropToMean(std::size_t brick, float mean);
    /// Bricks of the page that holds the fewest, where pages of their level have room for all of them
    /// elsewhere: dropping them frees the page at no cost in the end. Empty where there is none.
    std::vector<std::size_t> bricksOfSparsestPage() const;
    /// Gives the planes the entries as they are.
    void publish();

    /// Level of a brick that has samples here; nothing for all others.
    std::optional<int> residentLevel(std::size_t brick) const;
    /// Where they are; likewise.
    std::optional<AtlasSlot> slotOf(std::size_t brick) const;
    std::size_t pages() const { return pages_; }

  private:
    bool isResident(std::size_t brick) const;
    void evict(std::size_t brick);
    /// False when there is no room; then those loaded so far stay.
    bool loadBricks(std::vector<std::size_t> bricks, BrickCache& cache, Work& work);
    bool put(std::size_t brick, const Chunk& chunk, Work& work);
    void finish();

    glm::ivec3 bricks_, box_; // box_: pages
    std::size_t pages_;
    std::vector<Plane*> planes_;
    PageAllocator allocator_;
    Charge entriesCharge_;
    std::vector<BrickEntry> entries_;  // [z][y][x]
    std::vector<std::uint8_t> levels_; // [z][y][x]: of the brick's samples, here or absent
};

} // namespace tessera

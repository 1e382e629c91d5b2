// render/residency/brick_residency.h: the residency of bricks. Pages of 32^3 samples are divided into slots
// of one level (pages.h). Every brick has an entry with its slot, or with its value. It is CPU only:
// planes hold the bricks' data, in GL or in host memory (plane.h).
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
    /// Initially nothing is resident: every brick with samples of its own is absent.
    /// @param planes  hold the bricks' data; each has room for boxOf(pages); they outlive this
    /// @param pages  at least 1; may be fewer than the selection's if rays can wait (kFeaturePasses)
    BrickResidency(const VolumeInfo& info, const Selection& selection, std::size_t pages,
                   const TextureLimits& limits, std::vector<Plane*> planes, MemoryBudget& ram);

    /// For one picture. load() loads every brick of the selection through the cache, batch by batch; adopt()
    /// takes another selection, keeping common bricks. Both publish the entries.
    void load(BrickCache& cache, Work& work);
    void adopt(const Selection& selection);
    /// Makes the given bricks resident, evicting others if needed, and publishes the entries.
    /// @param bricks  numbers in the brick grid, each once; must fit into the pages together
    void serve(std::span<const std::size_t> bricks, BrickCache& cache, Work& work);

    /// For interactive pictures: bricks move one by one, and are drawn as means while they have no samples.
    /// Places bricks at their levels, replacing their slots, until there is no room; returns their number.
    /// publish() must follow before rays are drawn.
    std::size_t place(std::span<const BrickToPlace> bricks, Work& work);
    /// Frees the brick's slot; it is drawn as its mean.
    void dropToMean(std::size_t brick, float mean);
    /// Bricks of the sparsest page whose bricks all fit into other pages of their level: dropping them frees
    /// the page. Empty if there is none.
    std::vector<std::size_t> bricksOfSparsestPage() const;
    /// Passes the current entries to the planes.
    void publish();

    /// Level of a brick with samples here; nullopt for others.
    std::optional<int> residentLevel(std::size_t brick) const;
    /// Their slot; likewise.
    std::optional<AtlasSlot> slotOf(std::size_t brick) const;
    std::size_t pages() const { return pages_; }

  private:
    bool isResident(std::size_t brick) const;
    void evict(std::size_t brick);
    /// False if there is no room; bricks loaded so far stay.
    bool loadBricks(std::vector<std::size_t> bricks, BrickCache& cache, Work& work);
    bool take(std::size_t brick, const Chunk& chunk, std::vector<BrickInSlot>& placed);
    void put(std::span<const BrickInSlot> placed, Work& work);
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

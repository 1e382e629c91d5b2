// render/atlas.h: bricks on the GPU: pages of voxels in one 3D texture without duplicated border voxels, and
// the index texture that says for every brick where it is, or what it stands for.
//
// Index texel (two 32-bit words) of a brick:
//   resident: x = page.x | page.y << 10 | page.z << 20, y = slot.x | slot.y << 5 | slot.z << 10
//   value:    x = 0x80000000,                           y = bits of its mean (float, stored units):
//             an empty brick, or one of the coarsest level
//   absent:   x = 0x40000000: wanted, not here yet
#pragma once

#include "bricking/brick_cache.h"
#include "bricking/selection.h"
#include "core/budget.h"
#include "core/volume.h"
#include "render/gl/objects.h"
#include "render/page_allocator.h"
#include "render/work.h"

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

/// What a GPU texture may be: from the context, or assumed where there is none.
struct TextureLimits {
    int maxExtent = 2048;
    std::size_t maxBytes = std::size_t{1} << 30;
};

/// Bytes of one texel. 8-bit volumes take 16 bits too: llvmpipe filters R8 to 256 levels only.
std::size_t texelBytes(ValueType type);
/// How stored values become texels and back: stored = 65535 * texel + bias for 16-bit texels.
struct TexelFormat {
    GLenum internal, external, type;
    bool normalised;
    float bias;
};
TexelFormat texelFormat(ValueType type);
/// Converts `count` stored values to texels of texelFormat(type).
void toTexels(ValueType type, const std::byte* stored, std::size_t count, std::byte* texels);

/// Pages that bricks take, from their number per level. The coarsest level takes none: its one sample stands
/// in the index, as an empty brick's mean does.
std::size_t pagesFor(const std::array<std::size_t, kLevelCount + 1>& counts);
/// Smallest box that holds so many pages; 0 along x when none can.
glm::ivec3 atlasPages(std::size_t pages, ValueType type, const TextureLimits& limits);
/// Bytes of that box; the largest size_t when none can.
std::size_t atlasBytes(std::size_t pages, ValueType type, const TextureLimits& limits);

class Atlas {
  public:
    /// Allocates pages and the index, nothing in them: every brick that has samples of its own is absent.
    /// selection and info must outlive this.
    /// @param pages  at least 1; may be fewer than the selection takes, where rays wait (kFeaturePasses)
    Atlas(const VolumeInfo& info, const Selection& selection, std::size_t pages, const TextureLimits& limits,
          Ledger& gpu, Ledger& ram);
    /// Loads every brick of the selection through the cache, batch by batch, and writes the index.
    void load(BrickCache& cache, Ledger& ram, Work& work);
    /// Makes the given bricks resident, evicting others where there is no room, and writes the index.
    /// @param bricks  numbers in the brick grid, each once; must fit into the pages together
    void serve(std::span<const std::size_t> bricks, BrickCache& cache, Ledger& ram, Work& work);
    void bind(GLuint voxelUnit, GLuint indexUnit) const;
    const glm::ivec3& extentTexels() const { return voxels_.extent(); }
    std::size_t pages() const { return pages_; }
    static std::size_t indexBytes(const glm::ivec3& bricks) { return 8 * cellCount(bricks); }
    /// RAM that loading takes besides the cache: one brick as texels, the index, and the driver's copy of it.
    static std::size_t stagingBytes(const VolumeInfo& info);

  private:
    bool isResident(std::size_t brick) const;
    void evict(std::size_t brick);
    /// False when there is no room; then those loaded so far stay.
    bool loadBricks(std::vector<std::size_t> bricks, BrickCache& cache, Ledger& ram, Work& work);
    bool uploadBrick(std::size_t brick, const Chunk& chunk, std::byte* staging, Work& work);
    void writeIndex();
    const VolumeInfo& info_;
    const Selection& selection_;
    std::size_t pages_;
    TexelFormat format_;
    GlTexture3d voxels_, index_;
    PageAllocator allocator_;
    Charge entriesCharge_;
    std::vector<glm::uvec2> entries_; // the index, [z][y][x]
};

/// One level as one texture, for proving that bricks change nothing.
GlTexture3d wholeLevelTexture(const VolumeInfo& info, int level, BrickCache& cache, Ledger& gpu, Ledger& ram);

} // namespace tessera

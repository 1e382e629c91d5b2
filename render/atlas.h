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
#include <optional>
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
/// Most pages whose box fits; 0: not even one.
std::size_t pagesThatFit(std::size_t bytes, ValueType type, const TextureLimits& limits);

/// A brick at a level below the coarsest, and the chunk that holds it.
struct BrickToPlace {
    std::size_t brick = 0;
    int level = 0;
    ChunkPointer chunk;
};
/// The chunk that holds a brick at a level: a chunk has 2^level bricks per edge.
ChunkKey chunkOf(std::size_t brick, int level, const glm::ivec3& bricks);

class Atlas {
  public:
    /// Allocates pages and the index, nothing in them: every brick that has samples of its own is absent.
    /// info must outlive this.
    /// @param pages  at least 1; may be fewer than the selection takes, where rays wait (kFeaturePasses)
    Atlas(const VolumeInfo& info, const Selection& selection, std::size_t pages, const TextureLimits& limits,
          Ledger& gpu, Ledger& ram);

    /// One picture. load() brings every brick of the selection through the cache, batch by batch; adopt()
    /// takes another selection, keeping what it has in common with the last. Both write the index.
    void load(BrickCache& cache, Ledger& ram, Work& work);
    void adopt(const Selection& selection);
    /// Makes the given bricks resident, evicting others where there is no room, and writes the index.
    /// @param bricks  numbers in the brick grid, each once; must fit into the pages together
    void serve(std::span<const std::size_t> bricks, BrickCache& cache, Ledger& ram, Work& work);

    /// Pictures that follow one another: bricks move one by one, each standing as its mean while it has no
    /// samples here. Places them at their levels, each in the stead of what it was, until there is no room;
    /// returns how many. The index is written by writeIndex().
    std::size_t place(std::span<const BrickToPlace> bricks, Ledger& ram, Work& work);
    /// The brick stands as its mean, and gives its room back.
    void dropToMean(std::size_t brick, float mean);
    /// Bricks of the page that holds the fewest, where pages of their level have room for all of them
    /// elsewhere: dropping them frees the page at no cost in the end. Empty where there is none.
    std::vector<std::size_t> bricksOfSparsestPage() const;
    void writeIndex();
    /// Level of a brick that has samples here; nothing for all others.
    std::optional<int> residentLevel(std::size_t brick) const;

    void bind(GLuint voxelUnit, GLuint indexUnit) const;
    const glm::ivec3& extentTexels() const { return voxels_.extent(); }
    std::size_t pages() const { return pages_; }
    static std::size_t indexBytes(const glm::ivec3& bricks) { return 8 * cellCount(bricks); }
    /// RAM that loading takes besides the cache: one brick as texels, the index, levels, and the driver's
    /// copy of the index.
    static std::size_t stagingBytes(const VolumeInfo& info);

  private:
    bool isResident(std::size_t brick) const;
    void setEntries(const Selection& selection);
    void evict(std::size_t brick);
    /// False when there is no room; then those loaded so far stay.
    bool loadBricks(std::vector<std::size_t> bricks, BrickCache& cache, Ledger& ram, Work& work);
    bool uploadBrick(std::size_t brick, const Chunk& chunk, std::byte* staging, Work& work);
    glm::ivec3 bricks_;
    const VolumeInfo& info_;
    std::size_t pages_;
    TexelFormat format_;
    GlTexture3d voxels_, index_;
    PageAllocator allocator_;
    Charge entriesCharge_;
    std::vector<glm::uvec2> entries_;  // the index, [z][y][x]
    std::vector<std::uint8_t> levels_; // [z][y][x]: of the brick's samples, here or absent
};

/// One level as one texture, for proving that bricks change nothing.
GlTexture3d wholeLevelTexture(const VolumeInfo& info, int level, BrickCache& cache, Ledger& gpu, Ledger& ram);

} // namespace tessera

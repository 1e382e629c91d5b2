// render/residency/plane.h: Plane, the interface of one kind of data that bricks have in their slots: values,
// and what is made from them (light). Residency decides where a brick is. Every plane keeps its own data in
// the same slot, in GL (gpu/atlas_plane.h) or in host memory.
#pragma once

#include "bricking/cache/brick_cache.h" // Chunk
#include "core/base/work.h"
#include "render/residency/page_allocator.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>

namespace tessera {

/// Where a brick is, or what it stands for (brick_residency.h).
using BrickEntry = glm::uvec2;

/// A brick's samples inside a chunk of the cache.
struct BrickSamples {
    const Chunk& chunk;
    glm::ivec3 first;      // in the chunk
    int edge;              // samples
    std::size_t brick = 0; // number in the brick grid
};

class Plane {
  public:
    virtual ~Plane() = default;
    /// Puts a brick's data where residency has placed it. Counts what it took in work.
    virtual void put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) = 0;
    /// No more bricks come for a while: lets go of what putting them took, in memory too.
    virtual void finish() {}
    /// Entries as rays are to read them from now on, [z][y][x].
    virtual void publish(std::span<const BrickEntry> entries) = 0;
};

} // namespace tessera

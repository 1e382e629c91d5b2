// render/residency/plane.h: Plane, the interface of one kind of data in bricks' slots: values, and data
// derived from them (light). Residency decides the slot of a brick. Every plane keeps its own data in the
// same slot, in GL (gpu/atlas.h) or in host memory.
#pragma once

#include "bricking/cache/brick_cache.h" // Chunk
#include "core/base/work.h"
#include "render/residency/pages.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>

namespace tessera {

/// The slot or the value of a brick (brick_residency.h).
using BrickEntry = glm::uvec2;

/// A brick's samples inside a chunk of the cache.
struct BrickSamples {
    const Chunk& chunk;
    glm::ivec3 first;      // in the chunk
    int edge;              // samples
    std::size_t brick = 0; // number in the brick grid
};

struct BrickInSlot {
    AtlasSlot slot;
    BrickSamples samples;
};

class Plane {
  public:
    virtual ~Plane() = default;
    /// Puts a brick's data into its slot. Counts the effort in work.
    virtual void put(const AtlasSlot& slot, const BrickSamples& samples, Work& work) = 0;
    /// The same for several bricks, in different slots.
    virtual void putAll(std::span<const BrickInSlot> bricks, Work& work) {
        for (const BrickInSlot& b : bricks)
            put(b.slot, b.samples, work);
    }
    /// True if several threads may put bricks at once, into different slots.
    virtual bool takesManyAtOnce() const { return false; }
    /// No more bricks come for a while: releases temporary memory.
    virtual void finish() {}
    /// Entries for rays from now on, [z][y][x].
    virtual void publish(std::span<const BrickEntry> entries) = 0;
};

} // namespace tessera

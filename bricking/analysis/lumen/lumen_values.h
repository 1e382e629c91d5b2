// bricking/analysis/lumen/lumen_values.h: values of level 0 for lumens. A value at any point is trilinear as
// in docs/sampling.md. The voxels that a threshold takes come chunk by chunk as bits.
#pragma once

#include "bricking/analysis/lumen/voxel_set.h"
#include "bricking/cache/brick_cache.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

namespace tessera {

/// Which values are lumen.
struct LumenRule {
    double threshold = 0; ///< physical units
    bool below = true;    ///< lumen is below it (air), else above it (contrast)
    /// Nothing brighter than this is lumen: bone and plaques beside contrast. Infinite for air.
    double brightest = std::numeric_limits<double>::infinity();
    /// How far on the lumen's side, physical units; at 0 and below it is wall.
    double depth(double value) const {
        return below ? threshold - value : std::min(value - threshold, brightest - value);
    }
    bool takes(double value) const { return depth(value) > 0; }
    /// Wide enough for a value on the wall's side of the threshold, and a hundredth of the way more.
    LumenRule orTaking(double value) const {
        LumenRule wider = *this;
        if (const double way = value - threshold; below ? way >= 0 : way <= 0)
            wider.threshold += 1.01 * way + (below ? 1e-6 : -1e-6) * std::abs(value);
        return wider;
    }
};

/// Reads level 0 through a cache; one thread's. Holds up to eight chunks.
class LumenValues {
  public:
    LumenValues(BrickCache& cache, const VolumeInfo& info) : cache_(cache), info_(info) {}
    const VolumeInfo& info() const { return info_; }
    /// Trilinear between voxel centres, physical units.
    /// @param place  voxel space; beyond the outermost centres it is clamped to them
    /// Throws what reading a chunk throws.
    double at(const glm::dvec3& place);
    double voxel(const glm::ivec3& voxel);
    /// Whether the place is in the volume, and its value lumen.
    bool inside(const glm::dvec3& place, const LumenRule& rule);

  private:
    BrickCache& cache_;
    const VolumeInfo& info_;
    struct Held {
        glm::ivec3 chunk{-1};
        ChunkPointer values;
    };
    std::array<Held, 8> held_; // by the parity of the chunk's place, so that a corner's eight are there
};

/// The voxels of a chunk that the rule takes; none beyond the volume's edge.
void chunkBits(const Chunk& chunk, const VolumeInfo& info, const glm::ivec3& at, const LumenRule& rule,
               ChunkRows& rows);

} // namespace tessera

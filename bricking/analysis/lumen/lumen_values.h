// bricking/analysis/lumen/lumen_values.h: values of level 0 for lumens. A value at any point is trilinear as
// in docs/sampling.md. The voxels that pass a threshold come chunk by chunk as bits.
#pragma once

#include "bricking/analysis/lumen/voxel_set.h"
#include "bricking/cache/brick_cache.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

namespace tessera {

/// The rule for values of the lumen.
struct LumenRule {
    double threshold = 0; ///< physical units
    bool below = true;    ///< lumen is below it (air), else above it (contrast)
    /// Nothing brighter than this is lumen: bone and plaques beside contrast. Infinite for air.
    double brightest = std::numeric_limits<double>::infinity();
    /// Distance to the threshold on the lumen's side, physical units; wall at 0 and below.
    double depth(double value) const {
        return below ? threshold - value : std::min(value - threshold, brightest - value);
    }
    bool takes(double value) const { return depth(value) > 0; }
    /// The rule widened to include a value on the wall's side, by a hundredth of the distance more.
    LumenRule orTaking(double value) const {
        LumenRule wider = *this;
        if (const double way = value - threshold; below ? way >= 0 : way <= 0)
            wider.threshold += 1.01 * way + (below ? 1e-6 : -1e-6) * std::abs(value);
        return wider;
    }
};

/// Reads level 0 through a cache; for one thread. Holds up to eight chunks.
class LumenValues {
  public:
    LumenValues(BrickCache& cache, const VolumeInfo& info) : cache_(cache), info_(info) {}
    const VolumeInfo& info() const { return info_; }
    /// Trilinear between voxel centres, physical units.
    /// @param place  voxel space; beyond the outermost centres it is clamped to them
    /// Throws as reading a chunk does.
    double at(const glm::dvec3& place);
    double voxel(const glm::ivec3& voxel);
    /// True if the point is in the volume, and its value lumen.
    bool inside(const glm::dvec3& place, const LumenRule& rule);

  private:
    BrickCache& cache_;
    const VolumeInfo& info_;
    struct Held {
        glm::ivec3 chunk{-1};
        ChunkPointer values;
    };
    std::array<Held, 8>
        held_; // by the parity of the chunk's position, so that the eight around a corner are all held
};

/// The voxels of a chunk that pass the rule; none beyond the volume's edge.
void chunkBits(const Chunk& chunk, const VolumeInfo& info, const glm::ivec3& at, const LumenRule& rule,
               ChunkRows& rows);

} // namespace tessera

// bricking/analysis/lumen/lumen_values.h: values of level 0 for lumens. A value at any point is trilinear as
// in docs/sampling.md. The voxels that pass a threshold come chunk by chunk as bits.
#pragma once

#include "bricking/analysis/lumen/voxel_set.h"
#include "bricking/cache/brick_cache.h"
#include "core/base/budget.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

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

// Denoised values of a volume, for decisions on them. Walls and lumens of one voxel survive if they stand out
// of the noise.

/// Level 0 of a volume, filtered twice by a bilateral mean over 3^3: weights fall with distance and with
/// difference of values, by the noise. A voxel beyond all but one of its 26 neighbours counts as the nearest
/// of these. Values have the volume's stored type. Chunks do not depend on callers or caches.
class QuietValues final : public ChunkSource {
  public:
    /// @param loud  of the volume's own values; must outlive this, and hold a chunk more for every thread
    /// that reads
    /// @param standard deviation of the noise, physical units, above 0
    /// @param readers  threads that read at once, whose work is charged to ram
    QuietValues(BrickCache& loud, const VolumeInfo& info, double deviation, MemoryBudget& ram, int readers);
    const VolumeInfo& info() const override { return info_; }
    /// Of level 0 alone.
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override;

  private:
    BrickCache& loud_;
    const VolumeInfo& info_;
    const double deviation_; // stored values
    Charge charge_;
};

/// The source of a lumen's values: the volume's own, or denoised ones once requested.
class LumenField {
  public:
    /// The cache takes a quarter of the free budget, at most 256 MiB; denoising takes as much again.
    LumenField(const ChunkSource& source, MemoryBudget& ram, int threads);
    void quieten(double deviation);
    /// Returns to the volume's own values; no caller may hold chunks of cache().
    void unquieten();
    BrickCache& cache() { return quietCache_ ? *quietCache_ : loud_; }

  private:
    std::size_t cacheBytes(int times) const;
    const VolumeInfo& info_;
    MemoryBudget& ram_;
    const int threads_;
    BrickCache loud_;
    std::optional<QuietValues> quiet_;
    std::optional<BrickCache> quietCache_;
};

} // namespace tessera

// bricking/analysis/lumen/quiet_values.h: denoised values of a volume, for decisions on them. Walls and
// lumens of one voxel survive if they stand out of the noise.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "core/base/budget.h"

#include <optional>

namespace tessera {

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

// bricking/analysis/lumen/quiet_values.h: denoised values of a volume, made before anything is decided on
// them. Walls of one voxel stay walls, and a lumen of one voxel a lumen, where they stand out of the noise.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "core/base/budget.h"

#include <optional>

namespace tessera {

/// Level 0 of a volume, each voxel the mean of those of its 5^3 neighbourhood that are like it as far as
/// noise lets one tell. It is twice a mean over 3^3, by distance and by how much values differ. A voxel that
/// is beyond all but one of its 26 neighbours counts as the next of them. Values are stored as the volume
/// stores them. A chunk's are the same whoever asks, whatever lies in the caches.
class QuietValues final : public ChunkSource {
  public:
    /// @param loud  of the volume's own values; must outlive this, and hold a chunk more for every thread
    /// that reads
    /// @param deviation  of the noise, physical units, above 0
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

/// Where a lumen's values come from: the volume's own, and without their noise from when that is asked for.
class LumenField {
  public:
    /// The cache takes a quarter of what is free, 256 MiB at most; another as much where noise is taken off.
    LumenField(const ChunkSource& source, MemoryBudget& ram, int threads);
    void quieten(double deviation);
    /// The volume's own values again; nobody may hold chunks of cache().
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

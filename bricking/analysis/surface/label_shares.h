// bricking/analysis/surface/label_shares.h: chosen labels as a volume of one value: the share of a sample's
// voxels that have one of them. Its surface of one half is the border at which pictures let a label end
// (docs/sampling.md, "Labels in slices").
#pragma once

#include "bricking/analysis/surface/surface_mesh.h"
#include "bricking/cache/chunk_source.h"
#include "bricking/labels/label_volume.h"
#include "core/base/budget.h"

#include <cstdint>
#include <vector>

namespace tessera {

class LabelShares : public ChunkSource {
  public:
    /// @param chosen   of every label of the table, in its order
    /// @param threads  that read at once; 0: all processors
    /// labels must outlive this. Throws InputError if ram cannot hold what reading takes.
    LabelShares(const LabelVolume& labels, const std::vector<bool>& chosen, MemoryBudget& ram, int threads);

    const VolumeInfo& info() const override { return info_; }
    /// Of floats from 0 to 1: at level 0 either, at coarser ones means over the voxels within the volume.
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override;
    /// Of all cells; as long as this lives.
    CellRanges ranges() const { return {cells_, low_, high_, 0}; }
    /// Some voxel has one of them.
    bool any() const;

  private:
    const LabelVolume& labels_;
    VolumeInfo info_;
    std::vector<std::uint8_t> bySet_; // 1: of the chosen ones
    glm::ivec3 cells_;
    Charge charge_;
    std::vector<float> low_, high_;
};

} // namespace tessera

// bricking/export/box_source.h: a box of one level of a volume, as a source of slices. It is read a few
// slices at a time, so a box never has to fit in memory.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "bricking/import/source/slab_source.h"
#include "bricking/store/buffer_pool.h"
#include "core/base/budget.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// Samples [low, high) of the array of a level.
struct LevelBox {
    int level = 0;
    glm::ivec3 low{0}, high{0};
    glm::ivec3 extent() const { return high - low; }
};

/// The whole of a level. Throws InputError naming --level for one that does not exist.
LevelBox wholeLevel(const VolumeInfo& info, int level);
/// The samples of a level that touch a box of level 0, in voxel space; what is outside of the volume is left
/// out. Throws InputError naming option for a box that is empty or lies outside.
LevelBox levelBoxOf(const VolumeInfo& info, int level, const glm::dvec3& low, const glm::dvec3& high,
                    const std::string& option);
/// The voxel space box around a box along the patient's axes, mm.
PatientBox voxelBoxAround(const VolumeInfo& info, const PatientBox& mm);

/// The box as a volume of its own: sample (i,j,k) of level l is the cube of 2^l voxels at 2^l (i,j,k).
/// Counts of changed voxels are those of the whole volume, and stay only where the box is all of level 0.
VolumeInfo infoOfBox(const VolumeInfo& whole, const LevelBox& box);

class BoxSource final : public SlabSource {
  public:
    /// Charges a buffer for every thread to ram. source and ram must outlive it.
    /// @param threads  that decode; 0: all processors
    BoxSource(const ChunkSource& source, const LevelBox& box, MemoryBudget& ram, int threads = 0);

    const VolumeInfo& info() const override { return info_; }
    void readSlices(int count, std::span<std::byte> out) override;
    std::string describe() const override;

    const LevelBox& box() const { return box_; }
    int nextSlice() const { return next_; }
    /// The next slice is the first one again.
    void rewind() { next_ = 0; }
    /// Slices up to the end of the chunks that hold the next one; 0 after the last one. Portions of so many
    /// decode each chunk once.
    int slicesOfChunks() const;

  private:
    const ChunkSource& source_;
    LevelBox box_;
    VolumeInfo info_;
    int threads_, next_ = 0;
    BufferPool buffers_;
};

} // namespace tessera

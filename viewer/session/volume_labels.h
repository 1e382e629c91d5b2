// viewer/session/volume_labels.h: the labels beside an open volume: their list, and those at a place.
#pragma once

#include "bricking/labels/label_table.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/labels.h"
#include "viewer/session/label_list.h"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Numbers of sets at voxels of one level, nearly in order. For one thread.
class LabelVoxels {
  public:
    /// @param voxels  LabelVolume::voxels(); outlives this
    LabelVoxels(const StoreReader& voxels, int level);
    /// @param voxel  of the level, inside the volume
    /// Throws InputError naming what cannot be read.
    std::size_t setAt(const glm::ivec3& voxel);

  private:
    const StoreReader& voxels_;
    int level_;
    glm::ivec3 chunkAt_{-1};
    std::vector<std::byte> chunk_; // the last one read
};

class VolumeLabels {
  public:
    /// Reads the labels of an imported store. Throws InputError naming the file that cannot be read, or where
    /// ram has no room for them.
    VolumeLabels(const Labels& labels, MemoryBudget& ram);

    LabelList list() const;
    /// The values of the labels that a voxel of level 0 has, ascending.
    /// @param voxels  of the same store
    /// @param voxel   clamped to the volume
    std::vector<std::uint32_t> at(const StoreReader& voxels, const glm::dvec3& voxel) const;

  private:
    LabelTable table_;            // with the names and colours of the scene
    std::vector<bool> hasVoxels_; // of labels
    Charge charge_;
};

} // namespace tessera

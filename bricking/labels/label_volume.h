// bricking/labels/label_volume.h: LabelVolume: an imported segmentation, on the lattice of its scan.
#pragma once

#include "bricking/labels/label_cells.h"
#include "bricking/labels/label_table.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"

#include <filesystem>

namespace tessera {

/// Grids are the same if their corners agree to so much of a voxel.
constexpr double kSameVoxels = 1e-3;
bool isSameGrid(const VolumeInfo& a, const VolumeInfo& b);
/// Throws InputError naming the labels where their voxels are not those of the volume.
void requireSameGrid(const StoreReader& labels, const VolumeInfo& volume);
/// Throws InputError that begins with where if both frames of reference are known and differ.
/// @param frame  of the labels
void requireSameFrame(const std::string& frame, const VolumeInfo& scan, const std::string& where);

class LabelVolume {
  public:
    /// Opens a store that importLabels() has made. Throws InputError naming the file that is missing, damaged
    /// or of another version, or where ram cannot hold the cells.
    LabelVolume(const std::filesystem::path& store, MemoryBudget& ram);

    /// Numbers of sets (u8 or u16): level 0 on the scan's lattice; coarser levels by majority of 2^3, ties to
    /// the rarer set.
    const StoreReader& voxels() const { return voxels_; }
    const LabelTable& table() const { return table_; }
    const LabelCells& cells() const { return cells_; }

  private:
    StoreReader voxels_;
    LabelTable table_;
    LabelCells cells_;
};

} // namespace tessera

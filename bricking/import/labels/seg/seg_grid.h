// bricking/import/labels/seg/seg_grid.h: the grid of voxels on which the frames of a DICOM Segmentation lie.
// Private to the reader of segmentations.
#pragma once

#include "bricking/import/labels/seg/seg_object.h"
#include "core/base/volume.h"

#include <string>
#include <vector>

namespace tessera {

struct SegGrid {
    VolumeInfo info;          // x along rows, y along columns, z along the normal
    std::vector<int> sliceOf; // of each frame
    std::vector<std::string> notes;
};

/// Slices at even distances from the first frame's position to the last one's, along the normal. Between them
/// slices without frames may lie. Throws InputError naming the file where distances are not multiples of one,
/// where frames do not lie above one another, and for geometry that is no volume's.
SegGrid segGridOf(const SegObject& seg);

} // namespace tessera

// bricking/import/source/cropped_source.h: a part of a file as a volume: a box of a source's voxels. A source
// of chunks reads those that the box touches; of others, slices and rows before the box are passed over where
// they can be read in any order, else read and let go.
#pragma once

#include "bricking/import/source/slab_source.h"

#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// The box of a source, before its first slice is read. A RandomSlabSource stays one. Memory beside the
/// source's: one of its slices, or the rows of one that the box has. Voxels of whole rows or slices that are
/// read count where sources count (VolumeInfo::clampedVoxels), also beside the box.
/// @param box  within the source, along its axes
/// @param part  for its info()
/// @param remarks  are added to its own
std::unique_ptr<SlabSource> cropSource(std::unique_ptr<SlabSource> source, const FileBox& box,
                                       const FilePart& part, std::vector<std::string> remarks);

} // namespace tessera

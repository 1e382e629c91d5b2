// bricking/import/source/oriented_source.h: a volume's axes brought losslessly to the nearest LPS order.
// Every volume in a store then runs towards patient left, posterior, superior along x, y, z, as far as voxels
// allow. Voxels are moved, never resampled; obliqueness and shear stay in the affine.
#pragma once

#include "bricking/import/source/slab_source.h"

#include <filesystem>
#include <memory>

namespace tessera {

/// The order that turns each axis of an affine to the patient axis it is nearest to: of all assignments, the
/// one whose cosines add up to most; flipped where the source axis runs the other way.
AxisOrder nearestLpsOrder(const glm::dmat4& patientFromVoxel);

/// What a volume is once its axes are in nearestLpsOrder: extent, affine and originalOrder change. Every
/// voxel keeps its patient position (to rounding in double).
VolumeInfo orientedInfo(const VolumeInfo& source);

/// The source in nearest LPS order. Memory: two slices. x and y are exchanged and reversed slice by slice; a
/// reversed z is read backwards where the source is a RandomSlabSource; else, and where another axis becomes
/// z, the voxels are spooled on the first read to an unlinked file in scratchFolder ("": the system's folder
/// for temporary files). Throws Error if that file cannot be written.
std::unique_ptr<SlabSource> orientToLps(std::unique_ptr<SlabSource> source,
                                        const std::filesystem::path& scratchFolder);

} // namespace tessera

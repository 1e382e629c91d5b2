// bricking/import/source/oriented_source.h: lossless reordering of a volume's axes to the nearest LPS order.
// Every volume in a store then runs towards patient left, posterior, superior along x, y, z, as closely as
// whole axes allow. Voxels are moved, never resampled; obliqueness and shear stay in the affine.
#pragma once

#include "bricking/import/source/slab_source.h"

#include <cstddef>
#include <filesystem>
#include <memory>

namespace tessera {

/// The order that maps each axis of an affine to the nearest patient axis: the assignment with the largest
/// sum of cosines. An axis is flipped if the source axis runs the other way.
AxisOrder nearestLpsOrder(const glm::dmat4& patientFromVoxel);

/// The volume with its axes in nearestLpsOrder: extent, affine and originalOrder change. Every voxel keeps
/// its patient position (to rounding in double).
VolumeInfo orientedInfo(const VolumeInfo& source);

/// Numbers along the axes of a volume in nearest LPS order, along those of its source.
template <class Vector> Vector alongSourceAxes(const VolumeInfo& oriented, const Vector& numbers) {
    Vector ofSource(0);
    for (int axis = 0; axis < 3; ++axis)
        ofSource[oriented.originalOrder.sourceAxis[static_cast<std::size_t>(axis)]] = numbers[axis];
    return ofSource;
}

/// A box of a volume in nearest LPS order, along the axes of its source.
FileBox alongSourceAxes(const VolumeInfo& oriented, const FileBox& box);

/// The source in nearest LPS order. Memory: two slices. x and y are exchanged and reversed slice by slice. A
/// reversed z is read backwards if the source is a RandomSlabSource. Else, and if another axis becomes z, the
/// voxels are spooled on the first read to an unlinked file in scratchFolder ("": the system's folder for
/// temporary files). Throws Error if that file cannot be written.
std::unique_ptr<SlabSource> orientToLps(std::unique_ptr<SlabSource> source,
                                        const std::filesystem::path& scratchFolder);

} // namespace tessera

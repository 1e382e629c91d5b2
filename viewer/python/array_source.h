// viewer/python/array_source.h: an array in memory as a source of slices. Its numbers are read where they
// lie, whatever their order, so that an import holds no second copy.
#pragma once

#include "bricking/import/source/slab_source.h"
#include "viewer/python/array_voxels.h"

#include <memory>

namespace tessera::python {

/// Its axes in nearest LPS order: by strides, without a copy. The memory must stay, unchanged, as long as the
/// source. Throws InputError naming the argument for a geometry or a slope that cannot be.
std::unique_ptr<SlabSource> makeArraySource(const ArrayVoxels& array);

} // namespace tessera::python

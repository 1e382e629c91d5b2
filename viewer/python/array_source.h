// viewer/python/array_source.h: an array in memory as a source of slices. Its numbers are read where they
// lie, whatever their order, so that an import holds no second copy.
#pragma once

#include "bricking/import/source/slab_source.h"
#include "bricking/import/source/slice_converter.h"

#include <array>
#include <cstddef>
#include <glm/mat4x4.hpp>
#include <memory>
#include <string>

namespace tessera::python {

/// An array's memory, and what its numbers mean.
struct ArrayVoxels {
    const std::byte* first = nullptr;        // its number [0, 0, 0]
    std::array<std::ptrdiff_t, 3> strides{}; // bytes, of x, y and z
    glm::ivec3 extent{0};
    FileType type = FileType::i16;
    bool isHalf = false; // floats of 16 bits; `type` is f32 then
    bool bigEndian = false;
    glm::dmat4 patientFromVoxel{1};
    bool orientationKnown = true;
    double slope = 1, intercept = 0; // physical value = slope * number + intercept
    std::string unit = {};
};

/// Its axes in nearest LPS order: by strides, without a copy. The memory must stay, unchanged, as long as the
/// source. Throws InputError naming the argument for a geometry or a slope that cannot be.
std::unique_ptr<SlabSource> makeArraySource(const ArrayVoxels& array);

} // namespace tessera::python

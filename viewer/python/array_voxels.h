// viewer/python/array_voxels.h: an array's memory, and copies of its blocks. Arrays lie in any order.
#pragma once

#include "bricking/import/source/slice_converter.h"

#include <array>
#include <cstddef>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

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

    /// Of a number as it lies in memory.
    std::size_t bytes() const { return isHalf ? 2 : bytesPerFileValue(type); }
};

/// Whole rows of several slices.
struct ArrayBlock {
    int slice = 0, slices = 0, row = 0, rows = 0;
};

/// Copies a block's numbers, as the array has them. Where numbers along z or y lie nearer one another than
/// those along x, several slices or rows are read together: what comes into the processor's cache with one
/// number is used before it goes.
/// @param out         [z][y][x]
/// @param sliceBytes  from a slice in `out` to the next one
void gatherBlock(const ArrayVoxels& array, const ArrayBlock& block, std::byte* out, std::size_t sliceBytes);

/// The pieces of a block, each of about so many bytes, or a row: of 32 slices where that is quicker to
/// gather.
std::vector<ArrayBlock> piecesOf(const ArrayVoxels& array, const ArrayBlock& block, std::size_t bytes);

} // namespace tessera::python

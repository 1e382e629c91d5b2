// viewer/python/array_voxels.cpp: see array_voxels.h.
#include "viewer/python/array_voxels.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace tessera::python {
namespace {

constexpr int kTile = 32; // numbers of two bytes: a line of the processor's cache

/// The axis, of those along which there are several numbers, whose numbers lie nearest one another.
std::size_t nearestAxis(const ArrayVoxels& array) {
    std::size_t nearest = 0;
    const auto strideOf = [&](std::size_t axis) {
        return array.extent[static_cast<int>(axis)] == 1 ? PTRDIFF_MAX : std::abs(array.strides[axis]);
    };
    for (std::size_t axis = 1; axis < 3; ++axis)
        if (strideOf(axis) < strideOf(nearest))
            nearest = axis;
    return nearest;
}

/// A row of numbers that lie `stride` bytes apart.
template <std::size_t kBytes>
void copyRow(const std::byte* from, std::ptrdiff_t stride, int count, std::byte* to) {
    if (stride == static_cast<std::ptrdiff_t>(kBytes)) {
        std::memcpy(to, from, kBytes * static_cast<std::size_t>(count));
        return;
    }
    for (int n = 0; n < count; ++n, from += stride, to += kBytes)
        std::memcpy(to, from, kBytes);
}

/// Of a plane of x and another axis, whose numbers lie near one another: by tiles, which are read along that
/// axis and written along x.
/// @param strideOut  bytes, from a row of x in `out` to the next one
template <std::size_t kBytes>
void copyPlane(const std::byte* from, std::ptrdiff_t strideX, std::ptrdiff_t strideOther, int width,
               int others, std::byte* out, std::size_t strideOut) {
    std::array<std::byte, kBytes * kTile * kTile> tile; // [x][other]
    for (int x = 0; x < width; x += kTile) {
        const int columns = std::min(kTile, width - x);
        for (int other = 0; other < others; other += kTile) {
            const int rows = std::min(kTile, others - other);
            for (int n = 0; n < columns; ++n)
                copyRow<kBytes>(from + (x + n) * strideX + other * strideOther, strideOther, rows,
                                tile.data() + kBytes * static_cast<std::size_t>(n * kTile));
            for (int n = 0; n < rows; ++n)
                copyRow<kBytes>(tile.data() + kBytes * static_cast<std::size_t>(n), kBytes * kTile, columns,
                                out + static_cast<std::size_t>(other + n) * strideOut +
                                    kBytes * static_cast<std::size_t>(x));
        }
    }
}

template <std::size_t kBytes>
void gather(const ArrayVoxels& array, const ArrayBlock& block, std::byte* out, std::size_t sliceBytes) {
    const auto [x, y, z] = array.strides;
    const int width = array.extent.x;
    const std::size_t rowBytes = kBytes * static_cast<std::size_t>(width), nearest = nearestAxis(array);
    const std::byte* const from = array.first + block.slice * z + block.row * y;
    if (nearest == 2) {
        for (int row = 0; row < block.rows; ++row)
            copyPlane<kBytes>(from + row * y, x, z, width, block.slices,
                              out + static_cast<std::size_t>(row) * rowBytes, sliceBytes);
        return;
    }
    for (int slice = 0; slice < block.slices; ++slice) {
        std::byte* const to = out + static_cast<std::size_t>(slice) * sliceBytes;
        if (nearest == 1)
            copyPlane<kBytes>(from + slice * z, x, y, width, block.rows, to, rowBytes);
        for (int row = 0; nearest == 0 && row < block.rows; ++row)
            copyRow<kBytes>(from + slice * z + row * y, x, width,
                            to + static_cast<std::size_t>(row) * rowBytes);
    }
}

} // namespace

void gatherBlock(const ArrayVoxels& array, const ArrayBlock& block, std::byte* out, std::size_t sliceBytes) {
    switch (array.bytes()) {
    case 1:
        return gather<1>(array, block, out, sliceBytes);
    case 2:
        return gather<2>(array, block, out, sliceBytes);
    case 4:
        return gather<4>(array, block, out, sliceBytes);
    default:
        return gather<8>(array, block, out, sliceBytes);
    }
}

std::vector<ArrayBlock> piecesOf(const ArrayVoxels& array, const ArrayBlock& block, std::size_t bytes) {
    const std::size_t rows =
        std::max<std::size_t>(bytes / (array.bytes() * static_cast<std::size_t>(array.extent.x)), 1);
    const int most = static_cast<int>(std::min<std::size_t>(rows, INT32_MAX));
    const int slices = nearestAxis(array) == 2 ? std::min(kTile, most) : 1;
    std::vector<ArrayBlock> pieces;
    for (int slice = 0; slice < block.slices; slice += slices)
        for (int row = 0; row < block.rows; row += most / slices)
            pieces.push_back({block.slice + slice, std::min(slices, block.slices - slice), block.row + row,
                              std::min(most / slices, block.rows - row)});
    return pieces;
}

} // namespace tessera::python

// bricking/import/files/hdf5/h5_types.h: extents and types of numbers, as messages of an HDF5 file say them.
// Private to the reader.
#pragma once

#include "bricking/import/files/hdf5/h5_object.h"
#include "bricking/import/source/slice_converter.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

constexpr std::size_t kMostH5Axes = 32; // as the library has it
constexpr std::uint64_t kH5Unlimited = ~std::uint64_t{0};

struct H5Space {
    std::vector<std::uint64_t> extents; // slowest first; of one number: none
    std::vector<std::uint64_t> most;    // that they may grow to; kH5Unlimited
    /// Of numbers; above 2^62: 2^62.
    std::uint64_t count() const;
};
struct H5Type {
    std::size_t bytes = 0;
    bool isText = false;                // of fixed length
    std::optional<FileType> number;     // of numbers that are read here; floats of 16 bits: f32
    bool isHalf = false, isBig = false; // floats of 16 bits; high bytes first
    std::string what;                   // "strings of varying length": for messages
};

/// These throw InputError naming the file for damage.
H5Space readH5Space(H5Bytes& bytes);
H5Type readH5Type(H5Bytes& bytes);

/// Of a data set.
struct H5Shape {
    H5Space space;
    H5Type type;
};
/// Nullopt: it is none.
std::optional<H5Shape> shapeOf(const H5Object& object);

} // namespace tessera

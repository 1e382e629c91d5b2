// bricking/import/files/hdf5/h5_set.h: a data set of an HDF5 file, as its header describes it: layout,
// filters, fill value. Private to the reader.
#pragma once

#include "bricking/import/files/hdf5/h5_object.h"
#include "bricking/import/files/hdf5/h5_types.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

struct H5Filter {
    int number = 0;
    std::string name;
    std::vector<std::uint32_t> values;
};
constexpr int kH5Deflate = 1, kH5Shuffle = 2, kH5Fletcher = 3;

/// How a data set's chunks are found.
enum class H5Index : std::uint8_t { oldTree, single, implicit, fixedArray, extensibleArray, tree };

struct H5Layout {
    enum class Kind : std::uint8_t { compact, contiguous, chunked } kind = Kind::contiguous;
    std::uint64_t at = kH5Nowhere;  // of numbers, or of what finds chunks
    std::optional<H5Bytes> compact; // the numbers
    std::vector<std::uint64_t> chunk;
    H5Index index = H5Index::oldTree;
    bool skipsPartial = false; // chunks beyond an end of the set are not filtered
    std::uint64_t singleBytes = 0;
    std::uint32_t singleMask = 0;
};

struct H5Set {
    std::string name; // for messages
    H5Space space;
    H5Type type;
    H5Layout layout;
    std::vector<H5Filter> filters;
    std::vector<std::byte> fill;  // a number
    std::uint64_t chunkBytes = 0; // of a chunk's numbers
};

/// Throws InputError naming the file and the set for damage, for filters other than deflate, shuffle and
/// fletcher32, for data in other files or sets, and chunks above 1 GiB.
H5Set readH5Set(const H5Object& object, const std::string& name);

} // namespace tessera

// bricking/import/files/hdf5/h5_object.h: the header of an object of an HDF5 file (a group, a data set, a
// type with a name) as messages. Private to the reader.
#pragma once

#include "bricking/import/files/hdf5/h5_bytes.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace tessera {

enum class H5Kind : std::uint8_t {
    space = 1,
    linkInfo = 2,
    type = 3,
    oldFill = 4,
    fill = 5,
    link = 6,
    externalFiles = 7,
    layout = 8,
    filters = 11,
    attribute = 12,
    continuation = 16,
    symbolTable = 17,
    attributeInfo = 21
};

struct H5Message {
    int kind = 0;
    bool isShared = false; // its bytes say where it is
    H5Bytes bytes;
};

/// Where a shared message is: the header of an object that holds it. Throws InputError naming the file for
/// another place.
std::uint64_t placeOfShared(H5Bytes& bytes);

struct H5Object {
    std::uint64_t at = 0;
    std::vector<H5Message> messages;
    bool has(H5Kind kind) const;
    /// The first of its kind; of a shared one, what it shares. Nullopt: none. Throws as readH5Object() does.
    std::optional<H5Bytes> find(H5Kind kind) const;
};

/// Throws InputError naming the file for damage, and for checksums that do not fit.
H5Object readH5Object(const H5File& file, std::uint64_t at);

} // namespace tessera

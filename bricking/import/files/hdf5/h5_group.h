// bricking/import/files/hdf5/h5_group.h: the links of a group of an HDF5 file. Private to the reader.
#pragma once

#include "bricking/import/files/hdf5/h5_object.h"

#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

struct H5Link {
    std::string name;
    std::uint64_t at = kH5Nowhere; // of the object's header; of links to names, within the file or not: none
    bool leadsOut = false;         // to another file
};

bool isH5Group(const H5Object& object);

/// Throws InputError naming the file for damage.
std::vector<H5Link> linksOf(const H5File& file, const H5Object& group);

/// An object below a group, by names of links to objects; nullopt: none.
std::optional<H5Object> objectBelow(const H5File& file, const H5Object& group,
                                    const std::vector<std::string>& names);

} // namespace tessera

// bricking/import/files/hdf5/h5_attributes.h: attributes and small sets of an HDF5 file, which say what its
// volumes are. Private to the reader.
#pragma once

#include "bricking/import/files/hdf5/h5_object.h"

#include <optional>
#include <string>
#include <vector>

namespace tessera {

// Up to 64 numbers; nullopt: others, or none. Throw InputError naming the file for damage.

/// Of a set that is not in chunks.
std::optional<std::vector<double>> smallNumbersOf(const H5Object& object);
/// Of an attribute.
std::optional<std::vector<double>> numbersAttribute(const H5Object& object, const std::string& name);
/// A text, or an array of letters; nullopt also for texts of varying length.
std::optional<std::string> textAttribute(const H5Object& object, const std::string& name);

} // namespace tessera

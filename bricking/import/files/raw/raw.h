// bricking/import/files/raw/raw.h: a raw file described by a JSON sidecar (docs/formats.md gives the keys).
#pragma once

#include "bricking/import/source/slab_source.h"

#include <filesystem>
#include <memory>

namespace tessera {

/// Opens X.json and the data file that it names, in the order of the file. Reads no voxels.
/// Throws InputError naming the sidecar for an unknown, missing or ill-typed key and for invalid geometry.
/// Throws it naming the data file if its size is not exactly that of the sidecar.
std::unique_ptr<SlabSource> openRaw(const std::filesystem::path& sidecar);

} // namespace tessera

// bricking/import/vtk/packed_arrays.h: what stands before the packed values of arrays in VTK's XML. VTK takes
// these numbers as they are: it divides by a block's bytes, and allocates as many blocks as they say.
#pragma once

#include "bricking/import/source/source_files.h"

#include <cstdint>

namespace tessera {

/// True if arrays are packed, as the first element says.
bool isPackedVtk(const InputFile& file);
/// Throws InputError naming the file for blocks of no bytes, for more of them than the file could hold, for a
/// last one longer than the others, and for more bytes than `mostBytes` in an array.
void checkPackedVtk(const InputFile& file, std::uint64_t mostBytes);

} // namespace tessera

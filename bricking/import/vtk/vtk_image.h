// bricking/import/vtk/vtk_image.h: VTK's images in XML (.vti), by VTK's reader, which reads slabs of them:
// values in text, in base64 or raw, plain or packed by zlib, LZ4 or LZMA, in one piece or several. It is a
// target of its own (tessera_vtk_image), which programs load with the first such file (viewer/cli/modules/).
#pragma once

#include "bricking/import/source/slab_source.h"

#include <filesystem>
#include <memory>

namespace tessera {

/// In the file's own order. VTK holds up to 16 MiB of slices, at least one, besides, and values in text
/// whole. Throws InputError naming the file for what VTK complains about, for an extent that the file cannot
/// hold, for one that has no end, and without one array of one number a voxel, or one that is named as the
/// scalars.
std::unique_ptr<SlabSource> openVtkImage(const std::filesystem::path& file);

} // namespace tessera

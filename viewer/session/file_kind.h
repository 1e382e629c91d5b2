// viewer/session/file_kind.h: which files are meshes beside a volume, by their names and first bytes.
#pragma once

#include <filesystem>

namespace tessera {

/// True for files of triangles (.ply, .stl, .obj, .gltf, .glb) and for DICOM structure sets of any name. It
/// throws nothing.
bool meansMesh(const std::filesystem::path& path);
/// True for a file that begins as a DICOM structure set.
bool meansStructureSet(const std::filesystem::path& path);

} // namespace tessera

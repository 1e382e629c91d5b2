// bricking/import/meshes/mesh_file.h: reads triangles of files: PLY, STL, OBJ, glTF (docs/formats.md,
// "Meshes"). A walk of our own comes first: counts against the file's size, elements, lists and references.
// Then VTK reads, and what it gives is checked again.
#pragma once

#include "core/base/budget.h"
#include "core/base/triangle_mesh.h"

#include <filesystem>

namespace tessera {

/// The file's triangles as it has them, polygons cut into fans. Its format is that of its ending: .ply, .stl,
/// .obj, .gltf, .glb. A PLY file without faces gives its points alone.
/// @param ram  is charged for what reading takes, before it is allocated; nothing is left charged
/// Throws InputError naming file, expected and found: for other formats, damage, counts that the file does
/// not hold, coordinates that are no finite numbers, no triangles or points, too little memory.
TriangleMesh readMesh(const std::filesystem::path& file, MemoryBudget& ram);

} // namespace tessera

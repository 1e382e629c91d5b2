// viewer/cli/input/mesh_input.h: the meshes of a scene, read and prepared for rays.
#pragma once

#include "core/base/budget.h"
#include "core/scene/scene.h"

#include <span>
#include <string>
#include <vector>

namespace tessera {

/// Sets SceneMesh::shape of every mesh that is drawn and has none: of its file, or of its tube. A file that
/// several meshes name is read once.
/// @param frames  framesOfPicture() (further_volumes.h)
/// @param ram  is charged for as long as the shapes are kept; outlives them
/// @return what was left out, in words
/// Throws InputError as readMesh() and shapeOfStructures() do.
std::vector<std::string> readMeshes(Scene& scene, const std::vector<std::string>& frames, MemoryBudget& ram);
/// The same for scenes that may outlive the budget: shapes have one of their own, within what is free of ram.
/// @return what they take, charged to ram
Charge readMeshesApart(Scene& scene, const std::vector<std::string>& frames, MemoryBudget& ram);
/// Gives meshes without a shape that of an equal file or tube among others, if there is one.
void adoptShapes(std::span<const SceneMesh> from, Scene& to);

} // namespace tessera

// viewer/cli/input/structure_input.h: the contours of a DICOM structure set as shapes.
#pragma once

#include "core/base/budget.h"
#include "core/scene/mesh.h"

#include <memory>
#include <string>
#include <vector>

namespace tessera {

/// True if a file begins as DICOM does, preamble and mark. Throws nothing.
bool beginsAsDicom(const std::filesystem::path& file);

/// Tubes around the contours of the structures that the mesh chooses, or closed surfaces of them, each
/// structure in its display colour or, where it has none, in one that follows from its number.
/// @param frames  framesOfPicture()
/// @param ram  is charged for as long as the shape is kept
/// @param notes  gets what was left out
/// Throws InputError as readStructureSet() does, for patterns that mean no structure, for coordinates that
/// are not LPS, and for a chosen structure whose frame of reference is known and none of the picture's.
std::shared_ptr<const Shape> shapeOfStructures(const SceneMesh& mesh, const std::vector<std::string>& frames,
                                               MemoryBudget& ram, std::vector<std::string>& notes);

} // namespace tessera

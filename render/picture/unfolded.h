// render/picture/unfolded.h: a tube's wall as a flat picture. Every row is a point on a line, every column an
// angle around it (docs/sampling.md, "Unfolded pictures"). Rays of perspective cameras on the line draw it,
// so every engine can.
#pragma once

#include "render/picture/render_scene.h"

#include <glm/vec3.hpp>
#include <span>

namespace tessera {

/// The origin of a row's rays, and their frame: unit, at right angles.
struct UnfoldedRow {
    glm::dvec3 at{0};           // mm, patient space
    glm::dvec3 along{0}, up{0}; // of the line; of the first column's left edge
};

/// The unit direction of a column's ray: from up, clockwise for a viewer along the line.
glm::dvec3 unfoldedDirection(const UnfoldedRow& row, double column, int columns);

/// @param rows  as many as the scene's picture has; the scene's camera is ignored
/// Levels are the finest, in as many passes as memory needs. A step that is left open is half a voxel. Every
/// pixel has one ray. Throws as renderScene() does, and InputError for modes that have no rays from an eye
/// (slices).
RenderResult renderUnfolded(const Scene& scene, std::span<const UnfoldedRow> rows, const StoreReader& store,
                            MemoryBudget& ram, MemoryBudget& gpu, const RenderOptions& options);

} // namespace tessera

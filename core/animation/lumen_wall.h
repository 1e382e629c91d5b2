// core/animation/lumen_wall.h: the wall of a hollow organ as an isosurface, for flights.
#pragma once

#include "core/animation/path.h"
#include "core/scene/scene.h"

namespace tessera {

/// Adds the wall to the scene's isosurfaces, unless one has that value, and sets mode isosurface. Returns
/// false, with the scene unchanged, if the scene has the largest number of isosurfaces.
bool showLumenWall(const Lumen& lumen, Scene& scene);

/// True if a film along the path shows the wall by default: the lumen is known, and no keyframe has a
/// function.
bool showsWallByDefault(const Path& path);

} // namespace tessera

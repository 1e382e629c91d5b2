// core/animation/lumen_wall.h: the wall of a hollow organ, shown to a flight as a surface where the lumen
// ends.
#pragma once

#include "core/animation/path.h"
#include "core/scene/scene.h"

namespace tessera {

/// Puts the wall among the scene's surfaces, where none has that value yet, and shows surfaces alone. False,
/// and the scene as it was, where it has as many as it may.
bool showLumenWall(const Lumen& lumen, Scene& scene);

/// Whether a film along the path shows the wall where nobody said what to show: the lumen is known, and no
/// keyframe brings a function.
bool showsWallByDefault(const Path& path);

} // namespace tessera

// core/scene/slice_view.h: how a scene's camera sees its slice.
#pragma once

#include "core/scene/scene.h"

namespace tessera {

/// Cosine between the camera's direction and the slice's normal, from 0, its edge, to 1, along the normal.
/// 1 for a view without a named side, which is along the normal. The scene's mode is slice.
double facingOf(const Scene& scene);
/// Less than 0.01 of that; false for other modes.
bool isSeenFromEdge(const Scene& scene);

} // namespace tessera

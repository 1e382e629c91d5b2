// viewer/session/scene_change.h: the differences between a wished scene and the drawn one: those that a
// renderer can take while it goes on, and those that need another renderer.
#pragma once

#include "core/scene/camera.h"
#include "core/scene/scene.h"

namespace tessera {

struct SceneChange {
    bool another = false; // more than a renderer can be told: it is made anew
    bool turned = false, recoloured = false, rewindowed = false, recut = false, relit = false;

    bool any() const { return another || turned || recoloured || rewindowed || recut || relit; }
};

/// @param wished, drawn  of one volume; a camera of wished by side is another one
/// @param camera         that is drawn
/// @param compiles       Engine::About's: whether cuts are part of what is compiled
SceneChange changeOf(const Scene& wished, const Scene& drawn, const Camera& camera, bool compiles);

} // namespace tessera

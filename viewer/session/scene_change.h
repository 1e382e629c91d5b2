// viewer/session/scene_change.h: the differences between a requested scene and the drawn one: those that a
// renderer can apply, and those that need another renderer.
#pragma once

#include "core/scene/camera.h"
#include "core/scene/scene.h"

namespace tessera {

struct SceneChange {
    bool another = false; // the renderer must be made again
    bool turned = false, recoloured = false, rewindowed = false, recut = false, relit = false;

    bool any() const { return another || turned || recoloured || rewindowed || recut || relit; }
};

/// @param the requested and the drawn scene of one volume; a camera by side counts as different
/// @param camera         that is drawn
/// @param compiles  Engine::About's: cuts are compiled into the shader
SceneChange changeOf(const Scene& wished, const Scene& drawn, const Camera& camera, bool compiles);

} // namespace tessera

// viewer/session/scene_change.h: the differences between a requested scene and the drawn one: those that a
// renderer can apply, and those that need another renderer.
#pragma once

#include "core/scene/camera.h"
#include "core/scene/scene.h"

#include <cstddef>
#include <vector>

namespace tessera {

struct SceneChange {
    bool another = false; // the renderer must be made again
    bool turned = false, rewindowed = false, recut = false, relit = false;
    std::vector<std::size_t> recoloured, faded; // volumes with another function, another opacity

    bool any() const {
        return another || turned || rewindowed || recut || relit || !recoloured.empty() || !faded.empty();
    }
};

/// @param the requested and the drawn scene; a camera by side counts as different
/// @param camera         that is drawn
/// @param compiles  Engine::About's: cuts are compiled into the shader
SceneChange changeOf(const Scene& wished, const Scene& drawn, const Camera& camera, bool compiles);

} // namespace tessera

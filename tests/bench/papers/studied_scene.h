// tests/bench/papers/studied_scene.h: a scene of one volume, as studies draw it.
#pragma once

#include "core/scene/scene.h"

namespace tessera::bench {

/// @param pixels  of the picture, an axis
inline Scene studiedScene(const TransferChoice& function, int pixels) {
    Scene scene;
    scene.volumes = {{}};
    scene.volumes.front().transferFunction = function;
    scene.imageSize = glm::ivec2(pixels);
    return scene;
}

} // namespace tessera::bench

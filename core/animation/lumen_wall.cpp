// core/animation/lumen_wall.cpp: see lumen_wall.h.
#include "core/animation/lumen_wall.h"

#include <algorithm>

namespace tessera {
namespace {

const glm::dvec3 kWallColour(0.72, 0.30, 0.20); // mucosa, linear

} // namespace

bool showLumenWall(const Lumen& lumen, Scene& scene) {
    if (std::none_of(scene.surfaces.begin(), scene.surfaces.end(),
                     [&](const Isosurface& surface) { return surface.value == lumen.shownAt(); })) {
        if (scene.surfaces.size() >= Scene::kMaxSurfaces)
            return false;
        scene.surfaces.push_back({lumen.shownAt(), kWallColour, 1});
    }
    scene.mode = Mode::isosurface;
    return true;
}

bool showsWallByDefault(const Path& path) {
    return path.lumen && !path.lines.empty() &&
           std::none_of(path.keyframes.begin(), path.keyframes.end(),
                        [](const Keyframe& key) { return key.transferFunction.has_value(); });
}

} // namespace tessera

// core/scene/slice_view.cpp: see slice_view.h.
#include "core/scene/slice_view.h"

#include "core/scene/camera.h"
#include "core/scene/mode.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <variant>

namespace tessera {

double facingOf(const Scene& scene) {
    glm::dvec3 towards(0);
    if (const auto* const view = std::get_if<FittedView>(&scene.camera)) {
        if (!view->named)
            return 1;
        towards = axesOf(*view).towards;
    } else {
        const auto& camera = std::get<Camera>(scene.camera);
        towards = glm::normalize(camera.position - camera.focalPoint);
    }
    return std::abs(glm::dot(towards, poseOf(scene.slice, glm::dvec3(0)).normal));
}

bool isSeenFromEdge(const Scene& scene) {
    constexpr double kEdge = 0.01;
    return scene.mode == Mode::slice && facingOf(scene) < kEdge;
}

} // namespace tessera

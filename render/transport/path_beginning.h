// render/transport/path_beginning.h: where a path of light begins, for layers of a picture
// (docs/sampling.md, "Layers"). One text for mirror and native.
#pragma once

#include "render/transport/traced_path.h"

namespace tessera {

struct PathBeginning {
    glm::vec3 place{0};  // voxels
    float any = 0;       // 1: a path begins here; 0: the ray sees nothing
    glm::vec3 albedo{0}; // of the tissue there, linear
    glm::vec3 normal{0}; // unit, patient space, on the viewer's side; 0 where the field is even
};

/// @param path  where PathTracer::start() put it
/// @param gradient  of the field there, voxels
inline PathBeginning beginningOf(const PathScene& scene, const TracedPath& path, const glm::vec3& gradient) {
    PathBeginning beginning{path.p, 1.0f, path.tissue.albedo, glm::vec3(0)};
    const glm::vec3 g = leaf::transformed(scene.optics->voxelFromPatientTransposed, gradient);
    const float length = std::sqrt(glm::dot(g, g));
    if (length > 0.0f)
        beginning.normal = glm::dot(g, path.travel) > 0.0f ? -g / length : g / length;
    return beginning;
}

} // namespace tessera

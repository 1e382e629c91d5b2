// render/geometry/shape_shade.h: the light that a scene's meshes take on its way.
#pragma once

#include "core/scene/mesh.h"
#include "render/geometry/shape.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace tessera {

/// A surface on the way of light.
struct ShadeStep {
    double t = 0, opacity = 0; // along the ray; of it
};

/// Appends all surfaces of meshes behind `from` and before `to`, in order. Cuts do not count: light is that
/// of uncut meshes, as that of the uncut volume.
inline void shadeSteps(std::span<const SceneMesh> meshes, const ShapeRay& ray, double from, double to,
                       std::vector<ShadeStep>& steps) {
    const std::size_t before = steps.size();
    for (const SceneMesh& mesh : meshes) {
        HitOrder after{from, 0};
        for (ShapeHit hit; mesh.shape->next(ray, after, to, {}, hit); after = hit.at)
            steps.push_back({hit.at.t, mesh.opacity});
    }
    std::stable_sort(steps.begin() + static_cast<std::ptrdiff_t>(before), steps.end(),
                     [](const ShadeStep& a, const ShadeStep& b) { return a.t < b.t; });
}

/// The share of light that comes through.
inline double shadeBetween(std::span<const SceneMesh> meshes, const ShapeRay& ray, double from, double to) {
    double left = 1;
    for (const SceneMesh& mesh : meshes) {
        HitOrder after{from, 0};
        for (ShapeHit hit; left > 0 && mesh.shape->next(ray, after, to, {}, hit); after = hit.at)
            left *= 1 - mesh.opacity;
    }
    return left;
}

} // namespace tessera

// render/transport/surface_crossings.h: isosurfaces on a way of light, as rays of the eye cross them
// (docs/sampling.md, "Isosurfaces").
#pragma once

#include "render/contract/cell_roots.h"
#include "render/empty_space/occupancy.h"
#include "render/transport/path_scene.h"
#include "render/transport/tracking.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

namespace tessera {

/// False if no cubic through these values, at ends and thirds of a piece, comes to an isovalue: between them
/// it is at most 0.316 of their range beyond it.
inline bool mayCross(const std::vector<float>& isovalues, float v0, float v1, float v2, float v3) {
    const float low = std::min(std::min(v0, v1), std::min(v2, v3)),
                high = std::max(std::max(v0, v1), std::max(v2, v3)), beyond = 0.33f * (high - low);
    for (const float isovalue : isovalues)
        if (isovalue >= low - beyond && isovalue <= high + beyond)
            return true;
    return false;
}

/// Calls visit(mm, surface) for every crossing, in order along the way, until it returns true; returns
/// whether it did.
/// @param field  value(p) and pitch(p) at a place in voxels
template <typename Field, typename Visit>
bool crossSurfaces(const PathScene& scene, Field& field, const Way& way, const Visit& visit) {
    float fastest = 0; // voxels per mm
    for (int axis = 0; axis < 3; ++axis)
        fastest = std::max(fastest, std::abs(way.perMm[axis]));
    if (!(fastest > 0.0f))
        return false;
    const Occupancy* const near = scene.surfaceOccupancy ? scene.surfaceOccupancy : scene.occupancy;
    const float margin = leaf::kPlaneMargin / fastest;
    const auto place = [&](float mm) { return way.from + mm * way.perMm; };
    float front = 0;
    bool known = false, ends = false;
    for (float w = 0; w < way.mm && !ends;) {
        const glm::vec3 p = place(w);
        float next = std::numeric_limits<float>::max();
        if (near)
            if (const std::optional<EmptyBox> empty = emptyBoxAt(*near, way.perMm, p)) {
                for (int axis = 0; axis < 3; ++axis)
                    if (way.perMm[axis] != 0.0f) {
                        const int side = way.perMm[axis] > 0.0f ? empty->high[axis] : empty->low[axis];
                        next = std::min(next, (static_cast<float>(side) - p[axis]) / way.perMm[axis]);
                    }
                next = w + next - static_cast<float>(kLeapMargin) / fastest;
                if (next > w) {
                    w = next;
                    known = false;
                    continue;
                }
                next = std::numeric_limits<float>::max();
            }
        const float pitch = field.pitch(p);
        for (int axis = 0; axis < 3; ++axis)
            if (way.perMm[axis] != 0.0f)
                next =
                    std::min(next, leaf::planeBehind(way.from[axis], way.perMm[axis], w, pitch, w + margin));
        next = std::min(std::max(next, std::nextafter(w, way.mm)), way.mm);
        if (near && isClear(*near, p, place(next))) {
            w = next;
            known = false;
            continue;
        }
        const float piece = next - w, begin = w;
        const float v0 = known ? front : field.value(p);
        const float v1 = field.value(place(w + piece * (1.0f / 3.0f)));
        const float v2 = field.value(place(w + piece * (2.0f / 3.0f)));
        const float v3 = field.value(place(next));
        if (mayCross(scene.isovalues, v0, v1, v2, v3))
            forEachCrossing<float>(v0, v1, v2, v3, scene.isovalues, [&](float u, std::size_t number) {
                ends = ends || visit(begin + u * piece, number);
            });
        front = v3;
        known = true;
        w = next;
    }
    return ends;
}

} // namespace tessera

// render/contract/strides.h: the number of segments that a ray takes at once (docs/sampling.md, "Ray";
// adaptive object-space sampling, course notes 2.11.1). The same as shaders/march_strides.glsl, for C++.
// Strides are aligned: one of 2^k segments starts at a multiple of 2^k. So the strides of a ray do not depend
// on the way in which it was traversed.
#pragma once

#include "render/contract/level_map.h"
#include "render/contract/ray.h"

#include <algorithm>
#include <bit>

namespace tessera {

/// The data that rays need to take strides. Uniform: every brick has one level, and map is not read.
struct Strides {
    const LevelMap* map = nullptr; // null: uniform
    int uniformSegments = 1;       // then: segments per stride, a power of two
    Sampling sampling = Sampling::limited;
    double segmentVoxels = 1; // q
};

/// Segments of the stride that starts at segment i, where one does.
template <typename Real> int strideAt(const Strides& strides, const SegmentedRay<Real>& ray, int i) {
    if (!strides.map)
        return strides.uniformSegments;
    const LevelMap& map = *strides.map;
    const auto place = cornerPlace(segmentStart(ray, i), glm::vec<3, Real>(map.extentVoxels), map.bricks);
    const int k = strideExponent(map.at(place.corner), place, strides.sampling,
                                 static_cast<Real>(strides.segmentVoxels), map.mostStride);
    return 1 << (i == 0 ? k : std::min(k, std::countr_zero(static_cast<unsigned>(i))));
}

/// First segment of the stride that holds segment i.
template <typename Real> int strideStart(const Strides& strides, const SegmentedRay<Real>& ray, int i) {
    if (!strides.map)
        return i & ~(strides.uniformSegments - 1);
    const LevelMap& map = *strides.map;
    int k = map.mostStride;
    if (strides.sampling !=
        Sampling::naive) { // a stride never reaches into a brick that is finer than itself
        const auto place = cornerPlace(segmentStart(ray, i), glm::vec<3, Real>(map.extentVoxels), map.bricks);
        k = std::min(k, static_cast<int>(map.at(place.corner).code(place.current)));
    }
    for (; k > 0; --k) {
        const int start = i & ~((1 << k) - 1);
        if (start + strideAt(strides, ray, start) > i)
            return start;
    }
    return i;
}

} // namespace tessera

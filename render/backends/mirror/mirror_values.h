// render/backends/mirror/mirror_values.h: rays that keep one of the values along them, or their mean
// (docs/sampling.md, "Modes"), on the CPU; counterpart of shaders/march_values_loop.glsl.
#pragma once

#include "core/base/work.h"
#include "render/backends/mirror/mirror_input.h"
#include "render/contract/kept_value.h"
#include "render/contract/ray.h"
#include "render/empty_space/value_bounds.h"

#include <algorithm>

namespace tessera {

/// Continues a ray to its end.
/// @param field  value(p) at a place in voxels
template <typename Real, typename Field>
void keepAlong(const SegmentedRay<Real>& ray, Field& field, const MirrorInput& input, Work& work,
               KeptValue<Real>& k) {
    const Optics& o = *input.optics;
    const bool least = o.reduction == Reduction::minimum;
    const Real end = least ? Real(0) : static_cast<Real>(o.table.size() - 1);
    k.any = k.any || ray.count > 0;
    for (int i = 0; i < ray.count;) {
        ++work.iterations;
        const int n = strideAt(input.strides, ray, i);
        const Real length = strideLength(ray, i, n);
        const glm::vec<3, Real> p = stridePosition(ray, i, length);
        if (input.bounds) {
            const int next = nextContributing(*input.bounds, input.strides, ray, i, n, p, k.kept);
            if (next > i) {
                i = next;
                continue;
            }
        }
        ++work.segments;
        ++work.samples;
        const Real value = field.value(p);
        if (o.reduction == Reduction::average) {
            k.kept = k.kept + length * value;
            k.length = k.length + length;
        } else {
            const Real place = clampedPlaceOf(o, value);
            k.kept = least ? std::min(k.kept, place) : std::max(k.kept, place);
            if (k.kept == end)
                return; // no value can change it
        }
        i += n;
    }
}

} // namespace tessera

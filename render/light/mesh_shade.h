// render/light/mesh_shade.h: meshes in the rays of shadow maps: behind a surface less light is left.
#pragma once

#include "render/geometry/shape_shade.h"
#include "render/light/deep_shadow_map.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace tessera {

/// The light left along a ray of a map, with that which surfaces take.
/// @param samples  of the volume, as lightAlong() gives them
/// @param steps    in order; t in mm, as the samples have it
/// @param shaded   output, replaced
inline void shadeSamples(std::span<const LightLeft> samples, std::span<const ShadeStep> steps,
                         std::vector<LightLeft>& shaded) {
    shaded.clear();
    float factor = 1;
    std::size_t next = 0;
    for (const ShadeStep& step : steps) {
        const auto mm = static_cast<float>(step.t);
        for (; next < samples.size() && samples[next].mm <= mm; ++next)
            shaded.push_back({samples[next].mm, factor * samples[next].light});
        float light = next > 0 ? samples[next - 1].light : 1;
        if (next > 0 && next < samples.size()) {
            const LightLeft &a = samples[next - 1], &b = samples[next];
            light = a.light + (b.light - a.light) * ((mm - a.mm) / (b.mm - a.mm));
        }
        shaded.push_back({mm, factor * light});
        factor *= static_cast<float>(1 - step.opacity);
        shaded.push_back({std::nextafter(mm, std::numeric_limits<float>::max()), factor * light});
    }
    for (; next < samples.size(); ++next)
        shaded.push_back({samples[next].mm, factor * samples[next].light});
}

} // namespace tessera

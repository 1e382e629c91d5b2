// render/light/deep_shadow_map.cpp: see deep_shadow_map.h.
#include "render/light/deep_shadow_map.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {
namespace {

/// Points of a fit within an error of all samples, starting at the first sample; at most one more than the
/// layers hold.
int fitted(std::span<const LightLeft> samples, float error, int layers,
           std::array<LightLeft, DeepShadowMap::kLayers + 1>& places) {
    int count = 0;
    places[static_cast<std::size_t>(count++)] = samples.front();
    LightLeft from = samples.front();
    float low = -std::numeric_limits<float>::infinity(), high = std::numeric_limits<float>::infinity();
    for (std::size_t n = 1; n < samples.size(); ++n) {
        const float along = samples[n].mm - from.mm;
        if (!(along > 0))
            continue; // rounding left no distance
        const float least = (samples[n].light - error - from.light) / along;
        const float most = (samples[n].light + error - from.light) / along;
        if (std::max(low, least) <= std::min(high, most)) {
            low = std::max(low, least);
            high = std::min(high, most);
            continue;
        }
        // No line from the last point passes all samples: adds a point at the previous sample.
        const float before = samples[n - 1].mm;
        const float slope = 0.5f * (low + high);
        from = {before, from.light + slope * (before - from.mm)};
        if (count > layers - 1)
            return layers + 1;
        places[static_cast<std::size_t>(count++)] = from;
        const float rest = samples[n].mm - from.mm;
        low = (samples[n].light - error - from.light) / rest;
        high = (samples[n].light + error - from.light) / rest;
    }
    const float last = samples.back().mm;
    if (last > from.mm) {
        if (count > layers - 1)
            return layers + 1;
        // Points beyond the last one have its light, the best approximation.
        const float slope = std::clamp((samples.back().light - from.light) / (last - from.mm), low, high);
        places[static_cast<std::size_t>(count++)] = {last, from.light + slope * (last - from.mm)};
    }
    return count;
}

} // namespace

DeepShadowMap::DeepShadowMap(int size, int layers)
    : ShadowMap(size), layers_(layers), rays_(static_cast<std::size_t>(size * size)) {
    TESSERA_CHECK(layers >= 2 && layers <= kLayers);
    for (Ray& ray : rays_) {
        ray.mm.fill(std::numeric_limits<float>::max());
        ray.light.fill(1);
    }
}

float DeepShadowMap::fit(const glm::ivec2& at, std::span<const LightLeft> samples, float error) {
    TESSERA_CHECK(error > 0);
    Ray& ray = rays_[static_cast<std::size_t>(at.y * size() + at.x)];
    if (samples.empty()) {
        ray.mm.fill(std::numeric_limits<float>::max());
        ray.light.fill(1);
        return error;
    }
    std::array<LightLeft, kLayers + 1> places;
    int count = fitted(samples, error, layers_, places);
    while (count > layers_) {
        error *= 2;
        count = fitted(samples, error, layers_, places);
    }
    for (std::size_t n = 0; n < kLayers; ++n) {
        const LightLeft& place = places[std::min(n, static_cast<std::size_t>(count - 1))];
        ray.mm[n] = place.mm;
        ray.light[n] = place.light;
    }
    return error;
}

/// Lines may miss 0 or 1 by the error.
float DeepShadowMap::lightOf(const Ray& ray, float mm) {
    std::size_t n = 0; // points that are not beyond: a count takes no branches
    for (const float at : ray.mm)
        n += at <= mm ? 1 : 0;
    if (n == 0 || n == kLayers)
        return std::clamp(ray.light[n == 0 ? 0 : kLayers - 1], 0.0f, 1.0f);
    const float light = ray.light[n - 1] + (ray.light[n] - ray.light[n - 1]) *
                                               ((mm - ray.mm[n - 1]) / (ray.mm[n] - ray.mm[n - 1]));
    return std::clamp(light, 0.0f, 1.0f);
}

float DeepShadowMap::nearest(const glm::vec2& at, float mm) const {
    const auto edge = static_cast<float>(size());
    if (!(at.x >= 0 && at.y >= 0 && at.x < edge && at.y < edge))
        return 1;
    const std::size_t ray =
        static_cast<std::size_t>(static_cast<int>(at.y) * size() + static_cast<int>(at.x));
    return lightOf(rays_[ray], mm);
}

float DeepShadowMap::between(const glm::vec2& at, float mm) const {
    const glm::vec2 corner(std::floor(at.x - 0.5f), std::floor(at.y - 0.5f));
    const glm::vec2 part = at - 0.5f - corner;
    const auto edge = static_cast<float>(size() - 1);
    float l00, l10, l01, l11;
    if (corner.x >= 0 && corner.y >= 0 && corner.x < edge && corner.y < edge) {
        const Ray* const ray =
            rays_.data() + static_cast<int>(corner.y) * size() + static_cast<int>(corner.x);
        l00 = lightOf(ray[0], mm), l10 = lightOf(ray[1], mm);
        l01 = lightOf(ray[size()], mm), l11 = lightOf(ray[size() + 1], mm);
    } else {
        const auto light = [&](float x, float y) { return nearest({corner.x + x, corner.y + y}, mm); };
        l00 = light(0.5f, 0.5f), l10 = light(1.5f, 0.5f), l01 = light(0.5f, 1.5f), l11 = light(1.5f, 1.5f);
    }
    const float above = l00 + part.x * (l10 - l00);
    const float below = l01 + part.x * (l11 - l01);
    return above + part.y * (below - above);
}

int DeepShadowMap::layersOf(const glm::ivec2& at) const {
    const Ray& ray = rays_[static_cast<std::size_t>(at.y * size() + at.x)];
    int count = 1;
    while (count < kLayers &&
           ray.mm[static_cast<std::size_t>(count)] > ray.mm[static_cast<std::size_t>(count - 1)])
        ++count;
    return count;
}

} // namespace tessera

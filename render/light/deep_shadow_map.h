// render/light/deep_shadow_map.h: deep shadow maps: the light left at each depth along rays from a light
// (course notes 4.2). Every ray has up to eight points, and the light falls linearly between them. The greedy
// fit of Lokovic and Veach (2000) keeps within an error at every sample. Where eight points are not enough,
// the allowed error is larger, and known.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace tessera {

/// The light left at a distance, mm, from the start of rays.
struct LightLeft {
    float mm = 0, light = 1;
};

class DeepShadowMap {
  public:
    static constexpr int kLayers = 8;
    /// Light below which a ray ends: the rest is invisible.
    static constexpr float kDark = 1.0f / 1024;

    /// @param size  rays along either side
    /// @param layers  points stored per ray, 2 to kLayers
    explicit DeepShadowMap(int size, int layers = kLayers);
    static std::size_t bytes(int size) { return sizeof(Ray) * static_cast<std::size_t>(size * size); }

    /// Stores a ray's light.
    /// @param samples  by distance, light falling from 1; none: unobstructed
    /// @param error  allowed error of the fit
    /// Returns the error bound at these samples: the one given, or twice, four times ... as much.
    float fit(const glm::ivec2& ray, std::span<const LightLeft> samples, float error);

    /// Light left at a distance along the nearest ray; interpolated between the four rays around the point.
    /// @param at  rays from the map's corner, the first one's centre at (0.5,0.5); unobstructed beyond its
    /// edges
    float nearest(const glm::vec2& at, float mm) const;
    float between(const glm::vec2& at, float mm) const;

    int size() const { return size_; }
    /// Of every ray its points' distances, then the light there: 2 * kLayers numbers.
    const float* numbers() const { return rays_.front().mm.data(); }
    int layersOf(const glm::ivec2& ray) const;

  private:
    struct Ray {
        std::array<float, kLayers> mm, light; // the last one repeated
    };
    static_assert(sizeof(Ray) == 2 * kLayers * sizeof(float));
    static float lightOf(const Ray& ray, float mm);

    int size_, layers_;
    std::vector<Ray> rays_;
};

} // namespace tessera

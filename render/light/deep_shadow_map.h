// render/light/deep_shadow_map.h: deep shadow maps: the light left at each depth along rays from a light
// (course notes 4.2). Every ray has up to eight points, and the light falls linearly between them. The greedy
// fit of Lokovic and Veach (2000) keeps within an error at every sample. Where eight points are not enough,
// the allowed error is larger, and known.
#pragma once

#include "render/light/shadow_map.h"

#include <array>
#include <vector>

namespace tessera {

class DeepShadowMap : public ShadowMap {
  public:
    static constexpr int kLayers = 8;
    /// Light below which a ray ends: the rest is invisible.
    static constexpr float kDark = 1.0f / 1024;

    /// @param size  rays along either side
    /// @param layers  points stored per ray, 2 to kLayers
    explicit DeepShadowMap(int size, int layers = kLayers);
    static std::size_t bytes(int size) { return sizeof(Ray) * static_cast<std::size_t>(size * size); }
    std::size_t bytes() const override { return bytes(size()); }
    float fit(const glm::ivec2& ray, std::span<const LightLeft> samples, float error) override;

    /// Light left at a distance along the nearest ray; interpolated between the four rays around the point.
    float nearest(const glm::vec2& at, float mm) const;
    float between(const glm::vec2& at, float mm) const override;

    /// Of every ray its points' distances, then the light there: 2 * kLayers numbers.
    const float* numbers() const override { return rays_.front().mm.data(); }
    int layersOf(const glm::ivec2& ray) const;

  private:
    struct Ray {
        std::array<float, kLayers> mm, light; // the last one repeated
    };
    static_assert(sizeof(Ray) == 2 * kLayers * sizeof(float));
    static float lightOf(const Ray& ray, float mm);

    int layers_;
    std::vector<Ray> rays_;
};

} // namespace tessera

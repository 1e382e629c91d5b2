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

/// What is left of the light at a distance, mm, from where rays start.
struct LightLeft {
    float mm = 0, light = 1;
};

class DeepShadowMap {
  public:
    static constexpr int kLayers = 8;
    /// Light below which a ray counts as ended: nothing that this leaves can be seen.
    static constexpr float kDark = 1.0f / 1024;

    /// @param size  rays along either side
    /// @param layers  places kept of a ray, 2 to kLayers
    explicit DeepShadowMap(int size, int layers = kLayers);
    static std::size_t bytes(int size) { return sizeof(Ray) * static_cast<std::size_t>(size * size); }

    /// Takes a ray's light.
    /// @param samples  by distance, light falling from 1; none: nothing is in its way
    /// @param error  that the fit may make
    /// Returns the error that it may make at these samples: the one given, or twice, four times ... as much.
    float fit(const glm::ivec2& ray, std::span<const LightLeft> samples, float error);

    /// Light left at a distance along the nearest ray; along the four around the place, interpolated.
    /// @param at  rays from the map's corner, the first one's middle at (0.5,0.5); beyond its edges
    /// there is nothing
    float nearest(const glm::vec2& at, float mm) const;
    float between(const glm::vec2& at, float mm) const;

    int size() const { return size_; }
    int layersOf(const glm::ivec2& ray) const;

  private:
    struct Ray {
        std::array<float, kLayers> mm, light; // the last one repeated
    };
    static float lightOf(const Ray& ray, float mm);

    int size_, layers_;
    std::vector<Ray> rays_;
};

} // namespace tessera

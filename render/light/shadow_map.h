// render/light/shadow_map.h: ShadowMap, the interface of what is kept of rays from a light: deep shadow maps
// (deep_shadow_map.h) and maps of first hits (first_hit_map.h).
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <span>

namespace tessera {

/// The light left at a distance, mm, from the start of rays.
struct LightLeft {
    float mm = 0, light = 1;
};

class ShadowMap {
  public:
    /// @param size  rays along either side
    explicit ShadowMap(int size) : size_(size) {}
    virtual ~ShadowMap() = default;
    int size() const { return size_; }
    virtual std::size_t bytes() const = 0;

    /// Stores a ray's light.
    /// @param samples  by distance, light falling from 1; none: unobstructed
    /// @param error  allowed error of the fit
    /// Returns the error bound of the fit at these samples: the one given, or twice, four times ... as much;
    /// 0 of maps that fit nothing.
    virtual float fit(const glm::ivec2& ray, std::span<const LightLeft> samples, float error) = 0;
    /// All rays are stored; before any look-up.
    virtual void finish() {}

    /// Share of light at a distance.
    /// @param at  rays from the map's corner, the first one's centre at (0.5,0.5); unobstructed beyond its
    /// edges
    virtual float between(const glm::vec2& at, float mm) const = 0;
    /// The numbers of a deep map, for packets of look-ups; else null.
    virtual const float* numbers() const { return nullptr; }

  private:
    int size_;
};

} // namespace tessera

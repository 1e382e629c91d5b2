// render/light/first_hit_map.h: shadow maps of first hits: along every ray from a light the distance at which
// its opacity first passes a threshold (course notes 4.1). What lies behind is in shadow. Such a map takes a
// sixteenth of a deep one's memory, and makes thin media cast all of a shadow or none. Percentage closer
// filtering compares with all rays around (Reeves, Salesin, Cook 1987). A variance map keeps the mean and the
// mean square of the distances around, which bound the share of light (Donnelly, Lauritzen 2006).
#pragma once

#include "render/light/shadow_map.h"

#include <limits>
#include <vector>

namespace tessera {

/// The inputs of a map of first hits.
struct FirstHits {
    float threshold = 0.5f; // opacity that is a hit, (0,1)
    int filter = 1;         // rays to either side that count
    /// mm. A hit up to this far in front of a place does not shade it: rays beside meet a tilted surface
    /// nearer to the light.
    float biasMm = 0;
    /// Of a view to one side of six: what is beyond its edge is as the edge is, not without hits.
    bool oneOfSides = false;
};

/// True if a place is so far beyond a map that no ray counts there; not a number: true.
bool isBeyond(const glm::vec2& at, int size, int filter);

/// The distance at which samples pass the threshold, between two of them linearly; infinite if they do not.
float firstHit(std::span<const LightLeft> samples, float threshold);

class FirstHitMap : public ShadowMap {
  public:
    FirstHitMap(int size, const FirstHits& hits);
    static std::size_t bytes(int size) {
        return sizeof(float) * static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    }
    std::size_t bytes() const override { return bytes(size()); }
    float fit(const glm::ivec2& ray, std::span<const LightLeft> samples, float error) override;
    /// The share of rays around the nearest one that hit nothing before the place.
    float between(const glm::vec2& at, float mm) const override;

  private:
    FirstHits hits_;
    std::vector<float> mm_;
};

class VarianceMap : public ShadowMap {
  public:
    /// Of the bound, this part is no light: elsewhere light bleeds through where shadows overlap.
    static constexpr float kBleeding = 0.2f;

    /// @param middleMm  distances are kept from here, so that their squares are small
    /// @param leastMm  least deviation of distances
    VarianceMap(int size, const FirstHits& hits, float middleMm, float leastMm);
    static std::size_t bytes(int size) {
        return sizeof(Moments) * static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    }
    std::size_t bytes() const override { return bytes(size()); }
    float fit(const glm::ivec2& ray, std::span<const LightLeft> samples, float error) override;
    /// Takes the mean over the rays around.
    void finish() override;
    /// The rays around that hit nothing, and Chebyshev's upper bound of those of the others that pass.
    float between(const glm::vec2& at, float mm) const override;

  private:
    struct Moments {
        float hits = 0, mm = 0, squares = 0; // of rays: the share that hits; its distances, and their squares
    };
    Moments at(int x, int y) const;

    FirstHits hits_;
    float middleMm_, leastMm_;
    std::vector<Moments> rays_;
};

} // namespace tessera

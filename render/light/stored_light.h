// render/light/stored_light.h: the light of all bricks of a selection in RAM, as samples for the contract's
// functions (render/contract/sampler.h). The mirror reads it.
#pragma once

#include "render/contract/leaves.h"
#include "render/contract/sampler.h"
#include "render/light/scene_light.h"

#include <cstdint>
#include <vector>

namespace tessera {

class StoredLight {
  public:
    StoredLight() = default;
    /// Computes the light of all bricks.
    /// @param ram  budget for its memory
    StoredLight(SceneLight& light, const FramePlan& scene, MemoryBudget& ram);

    /// The samples of one channel; of mixed levels if there is a level map.
    class Channel {
      public:
        Channel(const StoredLight& light, int channel) : light_(light), channel_(channel) {}
        const LevelMap& map() const { return *light_.map_; }
        const glm::ivec3& extent() const { return light_.extent_; }
        float at(const glm::ivec3& i) const { return at(light_.level_, i); }
        float at(int level, const glm::ivec3& i) const;
        float mean(const glm::ivec3& brick) const;
        bool isEmpty(const glm::ivec3& brick) const;

      private:
        const StoredLight& light_;
        int channel_;
    };

    /// Shares of light that reach a point.
    template <typename Real>
    leaf::ReceivedLight<Real> at(const glm::vec<3, Real>& p, const leaf::LightingNumbers& lighting) const {
        return leaf::receivedLight<Real>(lighting, [&](int channel) {
            Channel samples(*this, channel);
            const Real texel = map_ ? interblockValue(samples, p)
                                    : fieldValue(samples, p, Real(1) / static_cast<Real>(1 << level_));
            return texel * Real(1 / leaf::kLightOne);
        });
    }

  private:
    struct Brick {
        std::vector<std::uint16_t> texels; // channel by channel, edge^3 each
    };
    const LevelMap* map_ = nullptr;
    const Selection* selection_ = nullptr;
    int level_ = 0, channels_ = 0; // without mixed levels: of all bricks
    glm::ivec3 extent_{0};
    std::vector<Brick> bricks_;
    std::vector<std::uint16_t> standing_; // of bricks without samples, channel by channel
    Charge charge_;
};

} // namespace tessera

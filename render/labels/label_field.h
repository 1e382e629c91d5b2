// render/labels/label_field.h: labels' factors at any place, for the contract's functions
// (render/contract/sampler.h): for rays one by one. Few bricks are kept at a time.
#pragma once

#include "bricking/levels/selection.h"
#include "core/base/budget.h"
#include "render/contract/level_map.h"
#include "render/contract/sampler.h"
#include "render/labels/drawn_labels.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace tessera {

/// The texels of bricks, those used last; for several threads.
class LabelBricks {
  public:
    static constexpr std::size_t kMost = 32;
    /// labels and ram outlive it. Throws InputError where ram cannot hold the bricks.
    LabelBricks(const DrawnLabels& labels, MemoryBudget& ram);

    using Texels = std::shared_ptr<const std::vector<std::uint16_t>>;
    /// Channel by channel, 32^3 each, as DrawnLabels::fill() gives them.
    /// @param level  below the coarsest
    Texels get(std::size_t brick, int level);
    const DrawnLabels& labels() const { return labels_; }

  private:
    struct Kept {
        Texels texels;
        std::uint64_t used = 0;
    };
    const DrawnLabels& labels_;
    Charge charge_;
    std::mutex mutex_;
    std::map<std::pair<std::size_t, int>, Kept> kept_;
    std::uint64_t turn_ = 0;
};

/// For one thread.
class LabelField {
  public:
    /// All outlive it.
    /// @param map  of mixed levels, or null: all bricks have the selection's finest level
    LabelField(LabelBricks& bricks, const Selection& selection, const LevelMap* map,
               const glm::ivec3& extentVoxels)
        : bricks_(bricks), selection_(selection), map_(map), level_(selection.finest()),
          extent_(levelExtent(extentVoxels, level_)) {}

    /// The samples of one channel, as texels.
    class Channel {
      public:
        Channel(LabelField& field, int channel) : field_(field), channel_(channel) {}
        const LevelMap& map() const { return *field_.map_; }
        const glm::ivec3& extent() const { return field_.extent_; }
        float at(const glm::ivec3& i) const { return at(field_.level_, i); }
        float at(int level, const glm::ivec3& i) const { return field_.at(channel_, level, i); }
        float mean(const glm::ivec3& brick) const {
            return field_.labels().standing(linearIndex(brick, field_.selection_.bricks), channel_);
        }
        bool isEmpty(const glm::ivec3& brick) const {
            return field_.selection_.levels[linearIndex(brick, field_.selection_.bricks)] ==
                   Selection::kEmpty;
        }

      private:
        LabelField& field_;
        int channel_;
    };

    template <typename Real> leaf::LabelShares<Real> shares(const glm::vec<3, Real>& p) {
        const auto at = leaf::placeOfLabels(labels().numbers(), p, [&] {
            return static_cast<Real>(1 << (map_ ? map_->levelAt(p) : level_));
        });
        return leaf::labelShares<Real>(labels().numbers(), [&](int channel) { return factor(channel, at); });
    }
    /// Of the labels' medium.
    template <typename Real> glm::vec<3, Real> gradient(const glm::vec<3, Real>& p) {
        const int solid = labels().numbers().solid;
        return leaf::mediumGradient<Real>(p, [&](const auto& at) { return factor(solid, at); });
    }
    const DrawnLabels& labels() const { return bricks_.labels(); }

  private:
    template <typename Real> Real factor(int channel, const glm::vec<3, Real>& p) {
        Channel samples(*this, channel);
        const Real texel = map_ ? interblockValue(samples, p)
                                : fieldValue(samples, p, Real(1) / static_cast<Real>(1 << level_));
        return texel * Real(1 / leaf::kLightOne);
    }
    float at(int channel, int level, const glm::ivec3& i);

    LabelBricks& bricks_;
    const Selection& selection_;
    const LevelMap* map_;
    int level_;
    glm::ivec3 extent_;
    struct Recent {
        std::size_t brick = SIZE_MAX;
        LabelBricks::Texels texels; // none: it is drawn as one value
    };
    std::array<Recent, 16> recent_; // by the low bits of a brick's place
};

} // namespace tessera

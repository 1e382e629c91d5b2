// render/transport/tracking.h: free paths and transmittance through the field as it is drawn, by null
// collisions with bounds of its extinction (docs/sampling.md, "Paths"). Neither has a step, nor a bias.
#pragma once

#include "core/base/work.h"
#include "render/contract/leaves.h"
#include "render/contract/ray_cuts.h"
#include "render/empty_space/extinction_bounds.h"
#include "render/empty_space/occupancy.h"
#include "render/transport/path_numbers.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

namespace tessera {

/// A straight way through the volume: places from + s * perMm, voxels, s mm, from 0 on.
struct Way {
    glm::vec3 from{0}, perMm{0};
    float mm = 0; // to where it ends
};

/// Where a way from p leaves the volume, mm; 0 from places that are not in it, and without a direction.
inline float mmToLeave(const glm::vec3& p, const glm::vec3& perMm, const glm::vec3& extent) {
    constexpr float kFarthest = 1e30f;
    float leave = std::numeric_limits<float>::max();
    for (int axis = 0; axis < 3; ++axis)
        if (perMm[axis] != 0.0f)
            leave = std::min(leave, ((perMm[axis] > 0.0f ? extent[axis] : 0.0f) - p[axis]) / perMm[axis]);
    return leave < kFarthest ? std::max(leave, 0.0f) : 0.0f;
}

/// Where a way from p leaves a slab that holds p, mm.
inline float mmToLeave(const glm::vec3& p, const glm::vec3& perMm, const RaySlab<float>& slab) {
    const float along = glm::dot(slab.normal, perMm);
    if (along == 0.0f)
        return std::numeric_limits<float>::max();
    return std::max(((along > 0.0f ? slab.high : slab.low) - glm::dot(slab.normal, p)) / along, 0.0f);
}

/// The parts of a way that cuts keep, in order, mm from its start.
inline void keptParts(const RayCuts& cuts, const Way& way, std::vector<RayPart>& parts) {
    cuts.parts(glm::dvec3(way.from), glm::dvec3(way.perMm), 0, static_cast<double>(way.mm), parts);
}
inline Way partOf(const Way& way, const RayPart& part) {
    return {way.from + static_cast<float>(part.from) * way.perMm, way.perMm,
            static_cast<float>(part.to - part.from)};
}

/// The boxes of bounds along a way, one after another.
class BoundedWay {
  public:
    /// @param occupancy  of the same function and levels: empty boxes are leapt over; null: they are not
    BoundedWay(const ExtinctionBounds& bounds, const Occupancy* occupancy, const Way& way)
        : bounds_(bounds), occupancy_(occupancy), way_(way) {
        float fastest = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const float along = way.perMm[axis];
            mmPer_[axis] = along != 0.0f ? 1.0f / along : 0.0f;
            fastest = std::max(fastest, std::abs(along));
        }
        least_ = leaf::kWayOverlap / fastest;
    }

    /// Goes on to the next box in which something may be. False at the way's end.
    bool next(PathWork& work) {
        while (end_ < way_.mm) {
            begin_ = end_;
            ++work.cells;
            const glm::vec3 p = way_.from + begin_ * way_.perMm;
            const glm::ivec3 voxel =
                glm::clamp(glm::ivec3(glm::floor(p)), glm::ivec3(0), bounds_.extentVoxels() - 1);
            const ExtinctionBounds::Box here = bounds_.at(voxel);
            const glm::ivec3 box = voxel >> here.shift;
            range_ = here.range;
            float end = leaves(box << here.shift, (box + 1) << here.shift, leaf::kWayOverlap);
            if (range_.most <= 0.0f && occupancy_)
                if (const std::optional<EmptyBox> empty = emptyBoxAt(*occupancy_, way_.perMm, p))
                    end = std::max(end, leaves(empty->low, empty->high, -static_cast<float>(kLeapMargin)));
            end_ = std::min(std::max(end, begin_ + least_), way_.mm);
            if (!(end_ > begin_)) // no number is between them
                end_ = std::nextafter(begin_, way_.mm);
            if (range_.most > 0.0f)
                return true;
        }
        return false;
    }
    float begin() const { return begin_; } // mm
    float end() const { return end_; }
    const ExtinctionRange& range() const { return range_; }

  private:
    float leaves(const glm::ivec3& low, const glm::ivec3& high, float beyond) const {
        float leave = std::numeric_limits<float>::max();
        for (int axis = 0; axis < 3; ++axis) {
            const float along = way_.perMm[axis];
            const float side = along > 0.0f ? static_cast<float>(high[axis]) + beyond
                                            : static_cast<float>(low[axis]) - beyond;
            if (along != 0.0f)
                leave = std::min(leave, (side - way_.from[axis]) * mmPer_[axis]);
        }
        return leave;
    }

    const ExtinctionBounds& bounds_;
    const Occupancy* occupancy_;
    const Way& way_;
    glm::vec3 mmPer_{0};
    float least_ = 0, begin_ = 0, end_ = 0;
    ExtinctionRange range_;
};

/// The distance to the first collision, mm; none: below 0. Collisions are tried as if the extinction were the
/// greatest of their box. One that is tried counts with the chance of extinction over greatest; where the
/// least extinction decides that, none is read (decomposition tracking, Kutz et al. 2017).
/// @param extinction  per mm at a place, voxels: f(place)
template <typename Extinction>
float freePath(const ExtinctionBounds& bounds, const Occupancy* occupancy, const Way& way,
               Extinction&& extinction, PathNumbers& numbers, PathWork& work) {
    BoundedWay boxes(bounds, occupancy, way);
    float depth = exponentialOf(numbers.next());
    while (boxes.next(work)) {
        const ExtinctionRange range = boxes.range();
        const float length = boxes.end() - boxes.begin();
        for (float at = 0.0f;;) { // from its beginning, so that short distances count too
            const float through = range.most * (length - at);
            if (!(through > depth)) {
                depth = depth - through;
                break;
            }
            at = at + depth / range.most;
            const float mm = boxes.begin() + at, share = numbers.next() * range.most;
            if (share < range.least)
                return mm;
            ++work.lookUps;
            const float here = extinction(way.from + mm * way.perMm);
            work.exceeded += here > range.most || here < range.least ? 1 : 0;
            if (share < here)
                return mm;
            ++work.nullCollisions;
            depth = exponentialOf(numbers.next());
        }
    }
    return -1.0f;
}

/// An unbiased estimate of the share of light that a way lets through: what is above the least extinction
/// takes its share at random places (residual ratio tracking, Novak et al. 2014). Ends by roulette where
/// little is left.
template <typename Extinction>
float transmittance(const ExtinctionBounds& bounds, const Occupancy* occupancy, const Way& way,
                    Extinction&& extinction, PathNumbers& numbers, PathWork& work) {
    BoundedWay boxes(bounds, occupancy, way);
    float depth = exponentialOf(numbers.next()), sure = 0.0f, left = 1.0f;
    while (boxes.next(work)) {
        const ExtinctionRange range = boxes.range();
        sure = sure + range.least * (boxes.end() - boxes.begin());
        if (sure > leaf::kDarkDepth)
            return 0.0f;
        const float most = range.most - range.least, length = boxes.end() - boxes.begin();
        for (float at = 0.0f;;) {
            const float through = most * (length - at);
            if (!(through > depth)) {
                depth = depth - through;
                break;
            }
            at = at + depth / most;
            ++work.lookUps;
            const float here = extinction(way.from + (boxes.begin() + at) * way.perMm);
            work.exceeded += here > range.most || here < range.least ? 1 : 0;
            left = left * (1.0f - (here - range.least) / most);
            if (left < leaf::kLittleLight) {
                if (!(left > 0.0f) || !(numbers.next() * leaf::kLittleLight < left))
                    return 0.0f;
                left = leaf::kLittleLight;
            }
            depth = exponentialOf(numbers.next());
        }
    }
    return sure > 0.0f ? left * (1.0f - leaf::oneMinusExp(sure)) : left;
}

} // namespace tessera

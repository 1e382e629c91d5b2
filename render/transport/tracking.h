// render/transport/tracking.h: free paths and transmittance through the field as it is drawn, by null
// collisions with bounds of its extinction (docs/sampling.md, "Paths"). Neither has a step, nor a bias.
#pragma once

#include "core/base/work.h"
#include "render/contract/leaves.h"
#include "render/empty_space/extinction_bounds.h"
#include "render/empty_space/occupancy.h"
#include "render/transport/path_numbers.h"

#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>

namespace tessera {

/// A straight way through the volume: places from + s * perMm, voxels, s mm, from 0 on.
struct Flight {
    glm::vec3 from{0}, perMm{0};
    float mm = 0; // to where it ends
};

/// Where a way from p leaves the volume, mm.
inline float mmToLeave(const glm::vec3& p, const glm::vec3& perMm, const glm::vec3& extent) {
    float leave = std::numeric_limits<float>::max();
    for (int axis = 0; axis < 3; ++axis)
        if (perMm[axis] != 0.0f)
            leave = std::min(leave, ((perMm[axis] > 0.0f ? extent[axis] : 0.0f) - p[axis]) / perMm[axis]);
    return std::max(leave, 0.0f);
}

/// The boxes of bounds along a way, one after another.
class BoundedWay {
  public:
    /// @param occupancy  of the same function and levels: empty boxes are leapt over; null: they are not
    BoundedWay(const ExtinctionBounds& bounds, const Occupancy* occupancy, const Flight& flight)
        : bounds_(bounds), occupancy_(occupancy), flight_(flight) {
        float fastest = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const float along = flight.perMm[axis];
            mmPer_[axis] = along != 0.0f ? 1.0f / along : 0.0f;
            fastest = std::max(fastest, std::abs(along));
        }
        least_ = leaf::kWayOverlap / fastest;
    }

    /// Goes on to the next box in which something may be. False at the way's end.
    bool next(PathWork& work) {
        while (end_ < flight_.mm) {
            begin_ = end_;
            ++work.cells;
            const glm::vec3 p = flight_.from + begin_ * flight_.perMm;
            const glm::ivec3 voxel =
                glm::clamp(glm::ivec3(glm::floor(p)), glm::ivec3(0), bounds_.extentVoxels() - 1);
            const ExtinctionBounds::Box here = bounds_.at(voxel);
            const glm::ivec3 box = voxel >> here.shift;
            range_ = here.range;
            float end = leaves(box << here.shift, (box + 1) << here.shift, leaf::kWayOverlap);
            if (range_.most <= 0.0f && occupancy_)
                if (const std::optional<EmptyBox> empty = emptyBoxAt(*occupancy_, flight_.perMm, p))
                    end = std::max(end, leaves(empty->low, empty->high, -static_cast<float>(kLeapMargin)));
            end_ = std::min(std::max(end, begin_ + least_), flight_.mm);
            if (!(end_ > begin_)) // no number between them
                end_ = flight_.mm;
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
            const float along = flight_.perMm[axis];
            const float side = along > 0.0f ? static_cast<float>(high[axis]) + beyond
                                            : static_cast<float>(low[axis]) - beyond;
            if (along != 0.0f)
                leave = std::min(leave, (side - flight_.from[axis]) * mmPer_[axis]);
        }
        return leave;
    }

    const ExtinctionBounds& bounds_;
    const Occupancy* occupancy_;
    const Flight& flight_;
    glm::vec3 mmPer_{0};
    float least_ = 0, begin_ = 0, end_ = 0;
    ExtinctionRange range_;
};

/// The distance to the first collision, mm; none: below 0. Distances are as far apart as the greatest
/// extinction makes them. A collision counts with the share of the extinction in it: where the least one
/// alone decides, none is read (decomposition tracking, Kutz et al. 2017).
/// @param extinction  per mm at a place, voxels: f(place)
template <typename Extinction>
float freePath(const ExtinctionBounds& bounds, const Occupancy* occupancy, const Flight& flight,
               Extinction&& extinction, PathNumbers& numbers, PathWork& work) {
    BoundedWay way(bounds, occupancy, flight);
    float depth = exponentialOf(numbers.next());
    while (way.next(work)) {
        const ExtinctionRange range = way.range();
        const float length = way.end() - way.begin();
        for (float at = 0.0f;;) { // from its beginning, so that short distances count too
            const float through = range.most * (length - at);
            if (!(through > depth)) {
                depth = depth - through;
                break;
            }
            at = at + depth / range.most;
            const float mm = way.begin() + at, share = numbers.next() * range.most;
            if (share < range.least)
                return mm;
            ++work.lookUps;
            const float here = extinction(flight.from + mm * flight.perMm);
            work.exceeded += here > range.most ? 1 : 0;
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
float transmittance(const ExtinctionBounds& bounds, const Occupancy* occupancy, const Flight& flight,
                    Extinction&& extinction, PathNumbers& numbers, PathWork& work) {
    constexpr float kLittle = 0.05f, kDark = 24.0f; // exp(-24) is below 2^-34
    BoundedWay way(bounds, occupancy, flight);
    float depth = exponentialOf(numbers.next()), sure = 0.0f, left = 1.0f;
    while (way.next(work)) {
        const ExtinctionRange range = way.range();
        sure = sure + range.least * (way.end() - way.begin());
        if (sure > kDark)
            return 0.0f;
        const float most = range.most - range.least, length = way.end() - way.begin();
        for (float at = 0.0f;;) {
            const float through = most * (length - at);
            if (!(through > depth)) {
                depth = depth - through;
                break;
            }
            at = at + depth / most;
            ++work.lookUps;
            const float here = extinction(flight.from + (way.begin() + at) * flight.perMm);
            work.exceeded += here > range.most ? 1 : 0;
            left = left * (1.0f - (here - range.least) / most);
            if (left < kLittle) {
                if (!(left > 0.0f) || numbers.next() < 0.5f)
                    return 0.0f;
                left = 2.0f * left;
            }
            depth = exponentialOf(numbers.next());
        }
    }
    return sure > 0.0f ? left * (1.0f - leaf::oneMinusExp(sure)) : left;
}

} // namespace tessera

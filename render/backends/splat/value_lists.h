// render/backends/splat/value_lists.h: the samples of a brick by value, for functions that change (Chen et
// al. 2004, 4.3), and their packed vertices (4.2.1). Comparisons alone use them: a brick is classified anew
// in a fraction of a millisecond, and these take 3.7 times the room of its values.
#pragma once

#include "core/base/brick.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace tessera {

/// Ranges of intervals of values, ascending and apart.
using Intervals = std::vector<std::pair<int, int>>; // from, to, to not included

/// The places of a brick's samples along each axis: by slice, then by interval, then by place.
class ValueLists {
  public:
    static constexpr int kIntervals = 256;

    /// @param values  32^3 of level 0, x fastest
    /// @param lowest, highest  of the volume, highest above lowest
    ValueLists(std::span<const float> values, float lowest, float highest);

    static int intervalOf(float value, float lowest, float highest);
    /// Places in the slice, x + 32 y along the slice's axes in ascending order, of the values in intervals.
    void collect(int axis, int slice, const Intervals& shown, std::vector<std::uint16_t>& out) const;
    std::size_t bytes() const {
        return places_.size() * sizeof(std::uint16_t) + starts_.size() * sizeof(std::uint16_t);
    }

  private:
    static constexpr std::size_t kSlice = std::size_t{kBrickExtent} * kBrickExtent, kStarts = kIntervals + 1;
    std::vector<std::uint16_t> places_; // [axis][slice][kSlice]
    std::vector<std::uint16_t> starts_; // [axis][slice][kStarts], in the slice
};

/// A vertex of a splat's quad in the 32 bits of the paper: place in a slice of at most 2^15 samples a side,
/// 8 bits and 7 bits each, and which corner.
struct PackedVertex {
    int x = 0, y = 0; // [0, 32767]
    bool right = false, top = false;
    bool operator==(const PackedVertex&) const = default;

    std::uint32_t packed() const {
        const auto px = static_cast<std::uint32_t>(x), py = static_cast<std::uint32_t>(y);
        return (px & 255) | (py & 255) << 8 | (px >> 8) << 16 | (py >> 8) << 23 | (right ? 1u << 30 : 0) |
               (top ? 1u << 31 : 0);
    }
    static PackedVertex of(std::uint32_t bits) {
        return {static_cast<int>((bits & 255) | ((bits >> 16) & 127) << 8),
                static_cast<int>(((bits >> 8) & 255) | ((bits >> 23) & 127) << 8), (bits >> 30 & 1) != 0,
                bits >> 31 != 0};
    }
};

} // namespace tessera

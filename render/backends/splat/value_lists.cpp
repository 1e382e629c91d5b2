// render/backends/splat/value_lists.cpp: see value_lists.h.
#include "render/backends/splat/value_lists.h"

#include "core/base/error.h"

#include <algorithm>

namespace tessera {

int ValueLists::intervalOf(float value, float lowest, float highest) {
    const float at = (value - lowest) / (highest - lowest) * kIntervals;
    return static_cast<int>(std::clamp(at, 0.0f, kIntervals - 1.0f));
}

ValueLists::ValueLists(std::span<const float> values, float lowest, float highest)
    : places_(3 * kBrickExtent * kSlice), starts_(3 * kBrickExtent * kStarts) {
    TESSERA_CHECK(values.size() == kBrickExtent * kSlice && highest > lowest);
    std::vector<std::uint8_t> intervals(values.size());
    std::transform(values.begin(), values.end(), intervals.begin(), [&](float value) {
        return static_cast<std::uint8_t>(intervalOf(value, lowest, highest));
    });
    constexpr std::array<std::size_t, 3> kPitch = {1, kBrickExtent, kSlice};
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t slice = 0; slice < kBrickExtent; ++slice) {
            const std::size_t a = kPitch[axis == 0 ? 1 : 0], b = kPitch[axis == 2 ? 1 : 2];
            const auto interval = [&](std::size_t place) {
                return std::size_t{intervals[slice * kPitch[axis] + place % 32 * a + place / 32 * b]};
            };
            std::uint16_t* const starts = starts_.data() + (axis * kBrickExtent + slice) * kStarts;
            std::uint16_t* const places = places_.data() + (axis * kBrickExtent + slice) * kSlice;
            for (std::size_t place = 0; place < kSlice; ++place)
                ++starts[interval(place) + 1];
            for (std::size_t n = 1; n < kStarts; ++n)
                starts[n] = static_cast<std::uint16_t>(starts[n] + starts[n - 1]);
            std::array<std::uint16_t, kIntervals> next;
            std::copy_n(starts, kIntervals, next.begin());
            for (std::size_t place = 0; place < kSlice; ++place)
                places[next[interval(place)]++] = static_cast<std::uint16_t>(place);
        }
}

void ValueLists::collect(int axis, int slice, const Intervals& shown, std::vector<std::uint16_t>& out) const {
    const auto at = static_cast<std::size_t>(axis) * kBrickExtent + static_cast<std::size_t>(slice);
    const std::uint16_t* const starts = starts_.data() + at * kStarts;
    const std::uint16_t* const places = places_.data() + at * kSlice;
    for (const auto& [from, to] : shown)
        out.insert(out.end(), places + starts[from], places + starts[to]);
}

} // namespace tessera

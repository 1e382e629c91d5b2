// render/backends/native/packet_numbers.h: random numbers of paths, a path a lane: those of
// render/transport/path_numbers.h, bit for bit. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"

namespace tessera::TESSERA_LANES {

/// The next of a path's random numbers (PathNumbers::next()), of lanes m.
struct LaneNumbers {
    I first, second, draws;
};
TESSERA_LANE I mixedBits(I n) {
    n = (n ^ shr<16>(n)) * I(0x7feb352d);
    n = (n ^ shr<15>(n)) * I(static_cast<std::int32_t>(0x846ca68bu));
    return n ^ shr<16>(n);
}
TESSERA_LANE F nextNumber(LaneNumbers& numbers, M m) {
    const I odd(static_cast<std::int32_t>(0x9e3779b9u));
    const I n = mixedBits(mixedBits(numbers.first + numbers.draws * odd) ^ numbers.second);
    numbers.draws = select(m, numbers.draws + I(1), numbers.draws);
    return number(shr<8>(n)) * F(0x1p-24f);
}
/// exponentialOf().
TESSERA_LANE F exponential(F u) {
    const F one(1.0f), half(0.5f), x = one - u;
    const I bits_ = asInt(x);
    F power = number(shr<23>(bits_) - I(127));
    F m = asFloat((bits_ & I(0x7fffff)) | I(0x3f800000));
    const M large = m > F(1.41421356f);
    m = select(large, half * m, m);
    power = select(large, power + one, power);
    const F s = (m - one) / (m + one), q = s * s;
    const F series =
        one + q * (F(1.0f / 3.0f) + q * (F(1.0f / 5.0f) + q * (F(1.0f / 7.0f) + q * F(1.0f / 9.0f))));
    return F(0.0f) - (power * F(0.693147181f) + F(2.0f) * s * series);
}

} // namespace tessera::TESSERA_LANES

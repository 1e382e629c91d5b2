// bricking/import/source/half_floats.h: floats of 16 bits (IEEE 754).
#pragma once

#include <bit>
#include <cstdint>

namespace tessera {

/// The float that is equal to a half.
inline float floatOfHalf(std::uint16_t half) {
    const std::uint32_t sign = std::uint32_t{half} >> 15 << 31, exponent = half >> 10 & 31,
                        fraction = half & 1023;
    constexpr float kLeast = 0x1p-24f; // of halves above 0
    constexpr std::uint32_t kInfinite = 31, kBias = 127 - 15;
    if (exponent == 0) {
        const float value = kLeast * static_cast<float>(fraction);
        return sign != 0 ? -value : value;
    }
    const std::uint32_t wide = exponent == kInfinite ? 255 : exponent + kBias;
    return std::bit_cast<float>(sign | wide << 23 | fraction << 13);
}

} // namespace tessera

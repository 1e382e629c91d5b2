// render/transport/path_numbers.h: the random numbers of a path, and the functions by which it takes
// distances and directions from them. Everything is written out, so that every processor gives the same bits.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace tessera {

/// Uniform numbers that follow from a place on the picture, a seed and the number of the draw, and from
/// nothing else. So a picture depends on no thread, no cut of the work, no budget and no order of bricks.
class PathNumbers {
  public:
    /// @param place  pixels
    PathNumbers(const glm::vec2& place, std::uint32_t seed) {
        const std::uint32_t x = std::bit_cast<std::uint32_t>(place.x),
                            y = std::bit_cast<std::uint32_t>(place.y);
        first_ = mixed(mixed(x + 0x9e3779b9u) ^ y) + seed;
        second_ = mixed(mixed(first_) ^ (x + (y << 16 | y >> 16)));
        first_ = mixed(first_);
    }

    /// The next one, from 0 to below 1: a multiple of 2^-24.
    float next() {
        const std::uint32_t n = mixed(mixed(first_ + draws_ * 0x9e3779b9u) ^ second_);
        ++draws_;
        return static_cast<float>(n >> 8) * 0x1p-24f;
    }
    std::uint32_t draws() const { return draws_; }

  private:
    /// A bijection in which every bit depends on every other (C. Wellons, Prospecting for Hash Functions,
    /// 2018: lowbias32).
    static std::uint32_t mixed(std::uint32_t n) {
        n = (n ^ (n >> 16)) * 0x7feb352du;
        n = (n ^ (n >> 15)) * 0x846ca68bu;
        return n ^ (n >> 16);
    }

    std::uint32_t first_ = 0, second_ = 0, draws_ = 0;
};

/// -ln(1 - u), u a multiple of 2^-24 from 0 to below 1, to a few ulp: an exponential variable of mean 1. It
/// is at most 16.7.
inline float exponentialOf(float u) {
    const float x = 1.0f - u; // exact
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(x);
    float power = static_cast<float>(static_cast<int>(bits >> 23) - 127);
    float m = std::bit_cast<float>((bits & 0x7fffffu) | 0x3f800000u); // x = m 2^power
    if (m > 1.41421356f) {
        m = 0.5f * m;
        power = power + 1.0f;
    }
    // ln m = 2 (s + s^3/3 + s^5/5 + ...), |s| at most 0.172
    const float s = (m - 1.0f) / (m + 1.0f), q = s * s;
    const float series = 1.0f + q * (1.0f / 3.0f + q * (1.0f / 5.0f + q * (1.0f / 7.0f + q * (1.0f / 9.0f))));
    return -(power * 0.693147181f + 2.0f * s * series);
}

/// Cosine and sine of 2 pi u, u from 0 to 1, to 2e-7.
inline glm::vec2 turnedBy(float u) {
    const float quarter = std::floor(4.0f * u + 0.5f);
    const float a = (u - 0.25f * quarter) * 6.28318531f, q = a * a; // within an eighth of a turn
    const float sine =
        a *
        (1.0f - q * (1.0f / 6.0f) *
                    (1.0f - q * (1.0f / 20.0f) * (1.0f - q * (1.0f / 42.0f) * (1.0f - q * (1.0f / 72.0f)))));
    const float cosine =
        1.0f -
        q * 0.5f * (1.0f - q * (1.0f / 12.0f) * (1.0f - q * (1.0f / 30.0f) * (1.0f - q * (1.0f / 56.0f))));
    switch (static_cast<int>(quarter) & 3) {
    case 0:
        return {cosine, sine};
    case 1:
        return {-sine, cosine};
    case 2:
        return {-cosine, -sine};
    default:
        return {sine, -cosine};
    }
}

/// The unit vector at an angle from an axis, turned around it by 2 pi u (axes at right angles to the axis:
/// Duff et al., Building an Orthonormal Basis, Revisited, 2017).
/// @param axis  unit
/// @param cosine  of the angle, -1 to 1
inline glm::vec3 directionAround(const glm::vec3& axis, float cosine, float u) {
    const float sign = axis.z >= 0.0f ? 1.0f : -1.0f;
    const float a = -1.0f / (sign + axis.z), b = axis.x * axis.y * a;
    const glm::vec3 across(1.0f + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    const glm::vec3 up(b, sign + axis.y * axis.y * a, -axis.y);
    const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine));
    const glm::vec2 turn = turnedBy(u);
    const glm::vec3 d = cosine * axis + (sine * turn.x) * across + (sine * turn.y) * up;
    return d / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
}

} // namespace tessera

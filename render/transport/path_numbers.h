// render/transport/path_numbers.h: the random numbers of a path, and the functions by which it takes
// distances and directions from them. Everything is written out, so that every processor gives the same bits.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
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
        const glm::vec2 pixel = glm::floor(place);
        pixel_ = mixed(mixed(std::bit_cast<std::uint32_t>(pixel.x) + seed) ^
                       std::bit_cast<std::uint32_t>(pixel.y));
        const std::uint32_t x = std::bit_cast<std::uint32_t>(place.x),
                            y = std::bit_cast<std::uint32_t>(place.y);
        first_ = mixed(mixed(x + 0x9e3779b9u) ^ y) + seed;
        second_ = mixed(mixed(first_) ^ (x + (y << 16 | y >> 16)));
        first_ = mixed(first_);
    }

    /// The number of the sample in its pixel (Rays::numbers): the first pairs of a pixel's paths are then
    /// strata.
    void setSample(std::uint32_t number) {
        sample_ = number;
        stratified_ = true;
    }

    /// Two numbers that make a direction, or one that makes a place. Pairs 0 to 3 of the paths of a set of
    /// samples are points of one (0,2)-net each, shuffled and scrambled by pixel, set, net and pair (Burley
    /// 2020, Practical Hash-based Owen Scrambling): each pair is spread evenly, and unrelated to the others.
    /// Later ones are drawn.
    glm::vec2 pair(std::uint32_t number) {
        const float a = next(), b = next();
        if (!stratified_ || number > 3)
            return {a, b};
        const std::uint32_t set = sample_ & 1u, index = sample_ >> 1;
        const std::uint32_t key =
            mixed(mixed(pixel_ + set + 2 * (index / kNet)) + 0x9e3779b9u * (number + 1));
        const std::uint32_t i = scrambled((index % kNet) << 25, mixed(key + 1)) >> 25; // shuffled
        const std::uint32_t x = reversed(i);
        std::uint32_t y = 0, direction = 1u << 31;
        for (std::uint32_t n = i; n != 0; n >>= 1, direction ^= direction >> 1)
            y ^= (n & 1u) != 0 ? direction : 0u;
        return {unit(scrambled(x, mixed(key + 2))), unit(scrambled(y, mixed(key + 3)))};
    }

    /// The next one, from 0 to below 1: a multiple of 2^-24.
    float next() {
        const std::uint32_t n = mixed(mixed(first_ + draws_ * 0x9e3779b9u) ^ second_);
        ++draws_;
        return unit(n);
    }
    /// For lanes that draw in its place: the two numbers that all draws follow from, and the count of draws.
    std::uint32_t first() const { return first_; }
    std::uint32_t second() const { return second_; }
    std::uint32_t draws() const { return draws_; }
    void setDraws(std::uint32_t draws) { draws_ = draws; }

  private:
    /// A bijection in which every bit depends on every other (C. Wellons, Prospecting for Hash Functions,
    /// 2018: lowbias32).
    static std::uint32_t mixed(std::uint32_t n) {
        n = (n ^ (n >> 16)) * 0x7feb352du;
        n = (n ^ (n >> 15)) * 0x846ca68bu;
        return n ^ (n >> 16);
    }

    static std::uint32_t reversed(std::uint32_t n) {
        n = (n >> 16) | (n << 16);
        n = ((n & 0xff00ff00u) >> 8) | ((n & 0x00ff00ffu) << 8);
        n = ((n & 0xf0f0f0f0u) >> 4) | ((n & 0x0f0f0f0fu) << 4);
        n = ((n & 0xccccccccu) >> 2) | ((n & 0x33333333u) << 2);
        return ((n & 0xaaaaaaaau) >> 1) | ((n & 0x55555555u) << 1);
    }
    /// Every bit flipped by a hash of those above it (Laine and Karras, Stratified Sampling for Stochastic
    /// Transparency, 2011; constants of N. Vegdahl).
    static std::uint32_t scrambled(std::uint32_t bits, std::uint32_t seed) {
        std::uint32_t n = reversed(bits);
        n ^= n * 0x3d20adeau;
        n += seed;
        n *= (seed >> 16) | 1u;
        n ^= n * 0x05526c56u;
        n ^= n * 0x53a22864u;
        return reversed(n);
    }
    static float unit(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

    static constexpr std::uint32_t kNet = 128; // kMostInSet of render/pixels/pixel_places.h
    std::uint32_t sample_ = 0;
    std::uint32_t pixel_ = 0;
    bool stratified_ = false;
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
    return 0.0f - (power * 0.693147181f + 2.0f * s * series);
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

/// The inverse: the share of a turn from x to (x, y), 0 to 1, to 1e-7.
inline float turnOf(float x, float y) {
    const float across = std::abs(x), along = std::abs(y);
    const float most = std::max(across, along);
    if (!(most > 0.0f))
        return 0.0f;
    float t = std::min(across, along) / most; // tangent, up to an eighth of a turn
    const bool isSteep = t > 0.414213562f;    // of a sixteenth
    if (isSteep)
        t = (t - 1.0f) / (t + 1.0f);
    const float q = t * t;
    const float arc =
        t *
        (1.0f -
         q * (1.0f / 3.0f -
              q * (1.0f / 5.0f -
                   q * (1.0f / 7.0f -
                        q * (1.0f / 9.0f - q * (1.0f / 11.0f - q * (1.0f / 13.0f - q * (1.0f / 15.0f))))))));
    float turn = arc * 0.159154943f + (isSteep ? 0.125f : 0.0f);
    turn = along > across ? 0.25f - turn : turn;
    turn = x < 0.0f ? 0.5f - turn : turn;
    return y < 0.0f ? 1.0f - turn : turn;
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

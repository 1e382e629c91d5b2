// render/pixels/pixel_places.cpp: see pixel_places.h.
#include "render/pixels/pixel_places.h"

#include "core/base/error.h"

#include <array>
#include <cmath>

namespace tessera {
namespace {

/// Mixes all bits (the finaliser of SplitMix64).
std::uint64_t mixed(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
}

constexpr int kBits = 7; // of kMostInSet

/// Owen's scrambling of a number of kBits bits: each bit is flipped by a random bit that depends on the bits
/// above it.
std::uint32_t scrambled(std::uint32_t number, std::uint64_t key) {
    const std::uint64_t upper = mixed(key); // a bit for every node of the first six levels
    std::uint32_t out = 0;
    for (int level = 0; level < kBits; ++level) {
        const std::uint64_t node = (1u << level) + (number >> (kBits - level));
        const std::uint64_t flip = node < 64 ? upper >> node : mixed(key + node);
        out = out << 1 | ((number >> (kBits - 1 - level) ^ static_cast<std::uint32_t>(flip)) & 1u);
    }
    return out;
}

/// The first two coordinates of Sobol' points, as whole numbers of kBits bits: bits reversed; Pascal's
/// triangle.
std::uint32_t firstCoordinate(std::uint32_t i) {
    std::uint32_t out = 0;
    for (int bit = 0; bit < kBits; ++bit)
        out = out << 1 | (i >> bit & 1u);
    return out;
}
std::uint32_t secondCoordinate(std::uint32_t i) {
    std::uint32_t out = 0, direction = 1u << (kBits - 1);
    for (; i != 0; i >>= 1, direction ^= direction >> 1)
        out ^= i & 1u ? direction : 0;
    return out;
}

/// Inverse of the normal distribution function, to 1.2e-9 of its value (P. J. Acklam's rational functions):
/// the same on every machine with IEEE 754 arithmetic and the same logarithm in the tails.
double normalQuantile(double p) {
    constexpr std::array a = {-3.969683028665376e+01, 2.209460984245205e+02,  -2.759285104469687e+02,
                              1.383577518672690e+02,  -3.066479806614716e+01, 2.506628277459239e+00};
    constexpr std::array b = {-5.447609879822406e+01, 1.615858368580409e+02, -1.556989798598866e+02,
                              6.680131188771972e+01, -1.328068155288572e+01};
    constexpr std::array c = {-7.784894002430293e-03, -3.223964580411365e-01, -2.400758277161838e+00,
                              -2.549732539343734e+00, 4.374664141464968e+00,  2.938163982698783e+00};
    constexpr std::array d = {7.784695709041462e-03, 3.224671290700398e-01, 2.445134137142996e+00,
                              3.754408661907416e+00};
    constexpr double tail = 0.02425;
    if (p > 1 - tail)
        return -normalQuantile(1 - p);
    if (p < tail) {
        const double q = std::sqrt(-2 * std::log(p));
        return (((((c[0] * q + c[1]) * q + c[2]) * q + c[3]) * q + c[4]) * q + c[5]) /
               ((((d[0] * q + d[1]) * q + d[2]) * q + d[3]) * q + 1);
    }
    const double q = p - 0.5, r = q * q;
    return (((((a[0] * r + a[1]) * r + a[2]) * r + a[3]) * r + a[4]) * r + a[5]) * q /
           (((((b[0] * r + b[1]) * r + b[2]) * r + b[3]) * r + b[4]) * r + 1);
}

} // namespace

double filteredOffset(double unit, PixelFilter filter) {
    if (filter == PixelFilter::box)
        return unit - 0.5;
    static const double below = 0.5 * std::erfc(kFilterReach / kFilterDeviation / std::sqrt(2.0));
    return kFilterDeviation * normalQuantile(below + unit * (1 - 2 * below));
}

void PixelPlaces::put(const glm::ivec2& pixel, std::uint32_t set, int first, std::span<glm::vec2> out) const {
    const std::uint64_t net = static_cast<std::uint32_t>(first / kMostInSet);
    first %= kMostInSet;
    TESSERA_CHECK(first >= 0 && first + static_cast<int>(out.size()) <= kMostInSet);
    const std::uint64_t at =
        std::uint64_t{static_cast<std::uint32_t>(pixel.y)} << 32 | static_cast<std::uint32_t>(pixel.x);
    const std::uint64_t key = mixed(mixed(at ^ mixed(seed_)) ^ mixed(net << 32 | set));
    const std::uint64_t keyX = mixed(key + 1), keyY = mixed(key + 2), keyWithin = mixed(key + 3);
    auto i = static_cast<std::uint32_t>(first);
    for (glm::vec2& place : out) {
        // Below those bits every sample is independently random, as with full scrambling.
        const std::uint64_t within = mixed(keyWithin + i);
        const auto unit = [](std::uint32_t upper, std::uint64_t bits24) {
            return (upper + (static_cast<double>(bits24 & 0xffffffu) + 0.5) / (1 << 24)) / kMostInSet;
        };
        const double x = unit(scrambled(firstCoordinate(i), keyX), within);
        const double y = unit(scrambled(secondCoordinate(i), keyY), within >> 32);
        place = glm::vec2(glm::dvec2(pixel) + 0.5 +
                          glm::dvec2(filteredOffset(x, filter_), filteredOffset(y, filter_)));
        ++i;
    }
}

} // namespace tessera

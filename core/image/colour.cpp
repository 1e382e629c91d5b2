// core/image/colour.cpp: see colour.h.
#include "core/image/colour.h"

#include <algorithm>
#include <cmath>

namespace tessera {

double srgbFromLinear(double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

double linearFromSrgb(double srgb) {
    const double x = std::clamp(srgb, 0.0, 1.0);
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

glm::dvec3 luvFromLinear(const glm::dvec3& rgb) {
    // IEC 61966-2-1 primaries, D65; rows give X, Y, Z with Y of white = 1.
    const double x = 0.4124564 * rgb.r + 0.3575761 * rgb.g + 0.1804375 * rgb.b;
    const double y = 0.2126729 * rgb.r + 0.7151522 * rgb.g + 0.0721750 * rgb.b;
    const double z = 0.0193339 * rgb.r + 0.1191920 * rgb.g + 0.9503041 * rgb.b;
    const double sum = x + 15 * y + 3 * z;
    if (!(sum > 0))
        return glm::dvec3(0);
    // u'_n, v'_n of the white (1,1,1) under this very matrix, so that greys have u* = v* = 0 exactly.
    constexpr double xn = 0.9504700, yn = 1.0000001, zn = 1.0888300;
    constexpr double sn = xn + 15 * yn + 3 * zn;
    constexpr double kappa = 24389.0 / 27, epsilon = 216.0 / 24389; // CIE 15: the exact rationals
    const double lightness = y > epsilon ? 116 * std::cbrt(y) - 16 : kappa * y;
    return {lightness, 13 * lightness * (4 * x / sum - 4 * xn / sn),
            13 * lightness * (9 * y / sum - 9 * yn / sn)};
}

} // namespace tessera

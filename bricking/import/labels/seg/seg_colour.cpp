// bricking/import/labels/seg/seg_colour.cpp: see seg_colour.h.
#include "bricking/import/labels/seg/seg_colour.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>

namespace tessera {

glm::vec3 linearFromDicomLab(std::uint32_t l, std::uint32_t a, std::uint32_t b) {
    constexpr double kMost = 65535;
    const double lightness = l * 100 / kMost, redness = a * 255 / kMost - 128,
                 yellowness = b * 255 / kMost - 128;
    const double fy = (lightness + 16) / 116, fx = fy + redness / 500, fz = fy - yellowness / 200;
    const auto inverse = [](double f) {
        constexpr double kBend = 6.0 / 29;
        return f > kBend ? f * f * f : 3 * kBend * kBend * (f - 4.0 / 29);
    };
    const glm::dvec3 white(0.96422, 1, 0.82521); // D50
    const glm::dvec3 xyz = white * glm::dvec3(inverse(fx), inverse(fy), inverse(fz));
    // From D50 (Bradford's adaptation to D65) to Rec. 709; columns.
    const glm::dmat3 rgbFromXyz(3.1338561, -0.9787684, 0.0719453, -1.6168667, 1.9161415, -0.2289914,
                                -0.4906146, 0.0334540, 1.4052427);
    return glm::vec3(glm::clamp(rgbFromXyz * xyz, 0.0, 1.0));
}

} // namespace tessera

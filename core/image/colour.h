// core/image/colour.h: colour spaces: linear Rec. 709 inside, sRGB for input and output, CIE 1976 L*u*v*
// (D65) for errors.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>

namespace tessera {

/// IEC 61966-2-1 transfer curve, per component; input clamped to [0,1].
double srgbFromLinear(double linear);
double linearFromSrgb(double srgb);
/// CIE 1976 L*u*v*, white point D65 (x 0.3127, y 0.3290); input linear Rec. 709 in [0,1]. Black gives 0.
glm::dvec3 luvFromLinear(const glm::dvec3& rgb);

/// Linear light of "#rrggbb" (sRGB) or of a name of CSS ("red", "grey"), in any case; nullopt for another
/// word.
std::optional<glm::vec3> findColour(const std::string& text);
/// The name nearest to an unknown word.
std::string nearestColour(const std::string& text);

} // namespace tessera

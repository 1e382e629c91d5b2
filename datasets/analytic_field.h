// datasets/analytic_field.h: phantoms of one formula each, with their gradients, at any point of patient
// space. Tests compare a sampled, stored and rendered volume with these formulas.
#pragma once

#include <glm/vec3.hpp>
#include <string>

namespace tessera {

inline constexpr double kAnalyticBodyMm = 256; ///< edge of the cube that the analytic phantoms fill
inline constexpr double kSphereRadiusMm = 80;  ///< where the sphere's value is 0
inline constexpr double kSphereSlopePerMm =
    25; ///< decrease of the sphere's value with the distance from its centre
inline constexpr double kSphereClamp = 1000;  ///< the sphere's values stay in [-1000, 1000]
inline constexpr int kCheckerboardVoxels = 8; ///< edge of a checkerboard box
inline constexpr double kMarschnerLobbFrequency = 6;
inline constexpr double kMarschnerLobbAlpha = 0.25;

/// Formulas are in README.md. Values are physical, before rounding to the stored type (only
/// the sphere rounds).
struct AnalyticField {
    enum class Kind { marschnerLobb, sphere, ramp, checkerboard };

    Kind kind = Kind::ramp;
    glm::ivec3 extentVoxels{1}; ///< the checkerboard is a formula of voxels, so it needs the grid

    /// @param name  "marschner-lobb", "sphere", "ramp" or "checkerboard"; throws InputError for another.
    static AnalyticField named(const std::string& name, const glm::ivec3& extentVoxels = glm::ivec3(1));

    /// @param patientMm  anywhere; the cube is [-128,128]^3 mm
    double value(const glm::dvec3& patientMm) const;
    /// Derivative of value() per mm; 0 where the sphere is clamped, at its centre, and in the checkerboard
    /// (away from its jumps). The Marschner-Lobb gradient on its axis is taken as its limit.
    glm::dvec3 gradient(const glm::dvec3& patientMm) const;
};

} // namespace tessera

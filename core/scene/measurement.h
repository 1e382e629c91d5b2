// core/scene/measurement.h: measurements of a scene: lengths, angles and circles between points in the
// patient. They use geometry alone and read no voxel.
#pragma once

#include "core/base/names.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace tessera {

enum class MeasurementKind { distance, angle, circle };

struct Measurement {
    MeasurementKind kind = MeasurementKind::distance;
    /// mm, patient space. Distance: both ends. Angle: an end, the corner, the other end. Circle: three places
    /// on it.
    std::vector<glm::dvec3> points;
    bool operator==(const Measurement&) const = default;
};

/// Number of points of a complete measurement of the kind.
std::size_t pointsOf(MeasurementKind kind);
template <> const NameTable<MeasurementKind>& namesOf<MeasurementKind>();
constexpr std::size_t kMaxMeasurements = 1000; // of a scene
/// Distance: mm. Angle: degrees, [0,180]. Circle: its radius, mm; infinite where the three lie on a line.
/// NaN where points are missing, or an angle's corner is one of its ends.
double valueOf(const Measurement& measurement);
/// The centre of a circle through three points, mm; the middle of the outer two if they lie on a line.
glm::dvec3 circleCentre(const Measurement& circle);
/// For people: "12.3 mm", "45.0 deg", "radius 12.3 mm, area 475 mm2".
std::string describe(const Measurement& measurement);

} // namespace tessera

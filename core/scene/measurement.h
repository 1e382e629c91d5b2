// core/scene/measurement.h: lengths in pictures: measurements of a scene, and the scale bar, which
// viewer/annotations/ draws.
#pragma once

#include "core/base/names.h"
#include "core/image/image.h"
#include "core/scene/camera.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace tessera {

// Measurements of a scene: lengths, angles and circles between points in the patient. They use geometry alone
// and read no voxel.

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

// A scale bar: a round length for a picture.

/// The largest length of 1, 2 or 5 times a power of ten that is at most `mm`; 1 if `mm` is no length.
double roundLength(double mm);

struct ScaleBar {
    double mm = 1, pixels = 1;
    bool everywhere = true; ///< else only at the depth of the picture's centre: nearer objects are larger

    /// "50 mm", "50 mm at the centre".
    std::string text() const;
};

/// At most a quarter of the picture's width. Exact across the direction of view: everywhere in parallel
/// projection, else at the depth of the camera's focal point, which is the picture's centre.
ScaleBar scaleBarOf(const Camera& camera, const glm::ivec2& imageSize);
/// For a plane that the picture shows at one scale.
/// @param width  of the picture, pixels
ScaleBar scaleBarOf(double mmPerPixel, double width);

} // namespace tessera

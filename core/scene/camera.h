// core/scene/camera.h: the camera of a picture, in patient space (LPS, mm). Names follow VTK.
#pragma once

#include "core/base/volume.h" // VolumeInfo: fitting

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace tessera {

enum class Projection { perspective, parallel };
/// The side of the patient that faces the viewer.
enum class View { anterior, posterior, left, right, superior, inferior };

struct Camera {
    Projection projection = Projection::perspective;
    glm::dvec3 position{0, -1000, 0}; // mm
    glm::dvec3 focalPoint{0, 0, 0};   // mm
    glm::dvec3 viewUp{0, 0, 1};
    double viewAngle = 30;      // full vertical angle, degrees, (0,180)
    double parallelScale = 100; // half the height of the view, mm; parallel projection only

    /// Throws InputError naming where for values that are not finite or beyond bounds
    /// (core/base/magnitude.h), a zero view direction, viewUp parallel to it, or an angle or scale out of
    /// range.
    void validate(const std::string& where) const;
    bool operator==(const Camera&) const = default;
};

/// The viewer's direction from the patient, degrees. Angle turn is about the axis from feet to head: 0 in
/// front, 90 at the patient's left, 180 behind. Angle rise is up towards the head, [-90,90].
struct ViewAngles {
    double turn = 0, rise = 0;
    bool operator==(const ViewAngles&) const = default;
};

/// A side of the patient's axes in patient space, unit: the picture's right and up, and towards the viewer.
/// Superior is up for the four horizontal views; for superior and inferior, anterior is up.
struct ViewAxes {
    glm::dvec3 right{0}, up{0}, towards{0};
};
ViewAxes viewAxes(View view);
/// Superior is up, or its projection; at a rise of 90, the direction opposite to the turn. Exact at multiples
/// of 90 degrees, so that 90,0 is `left`.
ViewAxes viewAxes(const ViewAngles& angles);

/// Finds the camera of a side whose picture holds all given boxes, as large as possible with a margin of 3 %.
/// Only the planes through the picture's edges count, so one pass over the boxes suffices. Boxes are along
/// the axes of the view: right, up, towards; mm.
class ViewFit {
  public:
    ViewFit(const ViewAxes& axes, Projection projection, const glm::ivec2& imageSize);
    ViewFit(View view, Projection projection, const glm::ivec2& imageSize)
        : ViewFit(viewAxes(view), projection, imageSize) {}
    const ViewAxes& axes() const { return axes_; }
    /// @param half  half the size of the box, positive
    void add(const glm::dvec3& centre, const glm::dvec3& half);
    /// Adds all boxes of another fit of the same picture.
    void add(const ViewFit& other);
    /// True if the picture holds the box already.
    bool holds(const glm::dvec3& centre, const glm::dvec3& half) const;
    bool empty() const { return !(nearest_ >= farthest_); }
    /// Looks at the middle of the boxes, at their middle depth; there must be one.
    Camera camera() const;

    /// The reach of all boxes, as by reachOf().
    const std::array<double, 4>& reach() const { return reach_; }
    /// The reach of a box towards the picture's right, left, upper and lower edge: the distance of the plane
    /// through the edge from the parallel plane through the origin, mm.
    std::array<double, 4> reachOf(const glm::dvec3& centre, const glm::dvec3& half) const;

  private:
    ViewAxes axes_;
    Projection projection_;
    double aspect_;      // width / height
    glm::dvec2 tangent_; // of half the picture, along right and up; 0: parallel
    std::array<double, 4> reach_;
    double nearest_, farthest_; // along towards
};

/// Looks at the whole volume from a side of the patient, or by angles. The volume's box fits the picture
/// tightly.
Camera fitCamera(const VolumeInfo& info, const ViewAxes& axes, Projection projection,
                 const glm::ivec2& imageSize);
inline Camera fitCamera(const VolumeInfo& info, View view, Projection projection,
                        const glm::ivec2& imageSize) {
    return fitCamera(info, viewAxes(view), projection, imageSize);
}

/// From the camera's axes to those of patient space: the picture's right, its up, and towards
/// the viewer, unit.
glm::dmat3 patientFromCamera(const Camera& camera);

/// A pixel's ray in patient space: base + t * direction, t in mm from minT on.
struct PatientRay {
    glm::dvec3 base{0}, direction{0};
    double minT = 0;
};

/// The camera prepared for rays: they pass through a plane near the volume, so that float coordinates stay
/// small even for a camera 1e6 mm away. Pixel (0,0) is the top left one; its centre is (0.5,0.5). base(pixel)
/// = centre + ndc.x * right + ndc.y * up, ndc in [-1,1], y up direction(pixel) = normalize(toCentre + ndc.x *
/// right + ndc.y * up) (perspective), forward (parallel) minT(pixel) = -|toCentre + ndc.x * right + ndc.y *
/// up| (perspective: the eye), -infinity (parallel)
struct RayPlane {
    glm::dvec3 centre{0}, right{0}, up{0}; // mm; right and up reach from the centre to the image's edge
    glm::dvec3 toCentre{0};                // perspective: centre - position
    glm::dvec3 forward{0};                 // unit
    bool perspective = true;
};
RayPlane rayPlane(const Camera& camera, const VolumeInfo& info, const glm::ivec2& imageSize);
/// The exact ray, in double. pixel may have a fraction.
PatientRay pixelRay(const RayPlane& plane, const glm::dvec2& pixel, const glm::ivec2& imageSize);

} // namespace tessera

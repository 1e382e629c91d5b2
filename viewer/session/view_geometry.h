// viewer/session/view_geometry.h: camera moves by the user: orbit, pan, zoom, roll and flight. Pure
// functions; lengths in mm of patient space, angles in radians. The three planes through a point, as pictures
// on a screen.
#pragma once

#include "core/base/volume.h"
#include "core/scene/camera.h"
#include "core/scene/labels.h"
#include "core/scene/mode.h"

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

namespace tessera {

/// The eye orbits the focal point, to the right of the picture and up by these angles. Objects on the picture
/// move the other way.
Camera orbited(const Camera& camera, const glm::dvec2& angles);
/// Moves objects at the focal point's depth along the picture, in parts of its height, x to the right, y
/// down.
Camera panned(const Camera& camera, const glm::dvec2& heights);
/// Enlarges objects at the focal point's depth by the factor: the eye comes nearer, or the scale becomes
/// smaller. Distances and scales stay between 1e-3 mm and 1e7 mm.
/// @param factor  positive
Camera zoomed(const Camera& camera, double factor);
/// The same, with the point under a given place of the picture fixed.
/// @param place  from the picture's centre, in heights, x to the right, y down
Camera zoomedAt(const Camera& camera, double factor, const glm::dvec2& place);
/// The picture turns clockwise.
Camera rolled(const Camera& camera, double angle);
/// The eye moves along the picture's right, its up, and forward, and its direction turns to the right and up.
Camera flown(const Camera& camera, const glm::dvec3& mm, const glm::dvec2& angles);
/// Centres the picture on the point; direction, distance and scale stay.
Camera centredOn(const Camera& camera, const glm::dvec3& point);
/// From a side of the patient, at the same focal point, distance and scale.
Camera seenFrom(const Camera& camera, View view);
/// Switches the projection, with the same size of objects at the focal point's depth.
Camera projectedBy(const Camera& camera, Projection projection);

/// Adapts the camera to another picture size so that its field of view stays visible: for a narrower aspect
/// angle or scale are larger. The eye stays.
/// @param from, to  pixels
Camera heldBy(const Camera& camera, const glm::ivec2& from, const glm::ivec2& to);

/// Half the height of the view at the focal point's depth, mm.
double halfHeightMm(const Camera& camera);
/// The distance from the eye to the focal point, mm.
double focalDistanceMm(const Camera& camera);

/// The position of a point on the picture, pixels; false behind the eye.
bool pictureFromPatient(const Camera& camera, const glm::ivec2& imageSize, const glm::dvec3& mm,
                        glm::dvec2& pixel);

/// Position of a plane on a picture.
struct SliceFrame {
    SlicePose pose;     // its point is at the picture's centre
    glm::ivec2 size{0}; // pixels
    double mmPerPixel = 1;

    /// The point at a pixel, mm; (0.5, 0.5) is the centre of the first.
    glm::dvec3 patientFromPicture(const glm::dvec2& pixel) const;
    /// The position of a point on the picture, projected along the plane's normal.
    glm::dvec2 pictureFromPatient(const glm::dvec3& mm) const;
};

/// The plane of an orientation through a point, with all of the volume's cross-section on the picture. It
/// stays in place on the picture when the point moves.
/// @param zoom  1: all of it; larger: nearer, around the point
SliceFrame sliceFrame(const VolumeInfo& info, Orientation orientation, const glm::dvec3& placeMm,
                      const glm::ivec2& size, double zoom = 1);

/// The content of the three planes.
struct SliceWish {
    glm::dvec3 placeMm{0};
    GreyWindow window;
    std::array<glm::ivec2, 3> sizes{}; // axial, coronal, sagittal, pixels; 0: not requested
    double zoom = 1;
    std::shared_ptr<const Labels> labels = {};         // over the planes, imported; null: none
    bool operator==(const SliceWish&) const = default; // labels: the same object
};

struct ShownSlice {
    SliceFrame frame;
    int level = 0;
    std::vector<std::uint32_t> display; // of the frame's size
};
struct ShownSlices {
    std::array<ShownSlice, 3> planes;
    SliceWish wish;
    bool fine = false; // at the level of a pixel's size; else finer ones follow
    double value = 0;  // at the point, physical units; NaN outside the volume
};

} // namespace tessera

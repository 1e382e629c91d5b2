// viewer/session/camera_moves.h: camera moves by the user: orbit, pan, zoom, roll and flight. Pure functions;
// lengths in mm of patient space, angles in radians.
#pragma once

#include "core/scene/camera.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

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

} // namespace tessera

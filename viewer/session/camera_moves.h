// viewer/session/camera_moves.h: camera moves of a hand: orbit, pan, zoom, roll and flight. Pure functions;
// lengths in mm of patient space, angles in radians.
#pragma once

#include "core/scene/camera.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace tessera {

/// The eye goes around the focal point, to the right of the picture and up by such angles. So what is seen
/// follows a hand that goes the other way.
Camera orbited(const Camera& camera, const glm::dvec2& angles);
/// What lies at the focal point's depth goes along the picture by such parts of its height, x to the
/// right, y down.
Camera panned(const Camera& camera, const glm::dvec2& heights);
/// What lies at the focal point's depth becomes larger by the factor: the eye comes nearer, or the scale
/// becomes smaller. Distances and scales stay between 1e-3 mm and 1e7 mm.
/// @param factor  positive
Camera zoomed(const Camera& camera, double factor);
/// The same, and what lies under the place of the picture stays there.
/// @param place  from the middle, in heights, x to the right, y down
Camera zoomedAt(const Camera& camera, double factor, const glm::dvec2& place);
/// The picture turns clockwise.
Camera rolled(const Camera& camera, double angle);
/// The eye goes along the picture's right, its up, and forward, and its gaze turns to the right and up.
Camera flown(const Camera& camera, const glm::dvec3& mm, const glm::dvec2& angles);
/// The point comes to the middle of the picture; direction, distance and scale stay.
Camera centredOn(const Camera& camera, const glm::dvec3& point);
/// From a side of the patient, at the same focal point, distance and scale.
Camera seenFrom(const Camera& camera, View view);
/// In the other projection, with the same size of what lies at the focal point's depth.
Camera projectedBy(const Camera& camera, Projection projection);

/// What the camera's picture of one size holds, that of another size holds too: where it is narrower in
/// proportion, angle or scale are larger. The eye stays.
/// @param from, to  pixels
Camera heldBy(const Camera& camera, const glm::ivec2& from, const glm::ivec2& to);

/// Half the height of what the picture shows at the focal point's depth, mm.
double halfHeightMm(const Camera& camera);
/// The distance from the eye to the focal point, mm.
double focalDistanceMm(const Camera& camera);

} // namespace tessera

// core/animation/flight.h: a flight: a smooth curve along a route of centre-lines, by arc length, with a
// rotation-minimising frame.
#pragma once

#include "core/animation/path.h"
#include "core/scene/scene.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// A pose on a curve: a place, the direction of view, up at right angles to it (unit vectors), and the least
/// distance from the place to the wall.
struct Pose {
    glm::dvec3 at{0}, direction{0, 0, 1}, up{0, 1, 0};
    double freeMm = 0;
};

/// A cubic B-spline over the route's points: place and direction have continuous curvature. It passes each
/// point on the inner side at a sixth of spacing^2 * curvature, which smooths noise. Places are by arc length
/// from where the flight begins, in the direction of the flight. All of it follows from the path alone.
class FlightCurve {
  public:
    /// @param lookAheadMm  one looks at the place on the curve so far ahead; 0: along the tangent
    FlightCurve(const std::vector<CentreLine>& lines, const Flight& flight);
    double lengthMm() const { return lengthMm_; }
    /// Distances to the wall are lower bounds: the distance changes by at most the distance moved.
    /// @param mm  0 to lengthMm(); held to it
    Pose at(double mm) const;
    /// Unit tangent there.
    glm::dvec3 tangent(double mm) const;

  private:
    struct Node { // kNodes a span of the spline
        double arcMm = 0, freeMm = 0;
        glm::dvec3 up{0};
    };
    double parameter(double mm) const;
    glm::dvec3 point(double u, int derivative = 0) const;
    glm::dvec3 place(double mm) const; // beyond the ends straight on
    glm::dvec3 direction(double mm) const;
    double freeAt(double u) const;
    glm::dvec3 carried(const glm::dvec3& up, double from, double to) const;

    std::vector<RoutePoint> control_; // one more at either end
    std::vector<Node> nodes_;
    double lengthMm_ = 0, lookAheadMm_ = 0;
};

/// The path flown the other way. Keyframes at places keep them, in the order in which they are then flown
/// over; those at times keep their times. The path has a flight.
Path flownTheOtherWay(Path path);

/// The camera of a pose, turned and moved as asked. It is never nearer to the wall than the flight's
/// clearance; where the lumen is too narrow for that, it stays on the line.
Camera cameraOf(const Pose& pose, const LookAround& look, const Flight& flight);
/// The direction for cameraOf() that looks from the pose at another point, mm.
LookAround lookTowards(const Pose& pose, const glm::dvec3& place);

// The wall of a hollow organ as an isosurface, for flights.

/// Adds the wall to the scene's isosurfaces, unless one has that value, and sets mode isosurface. Returns
/// false, with the scene unchanged, if the scene has the largest number of isosurfaces.
bool showLumenWall(const Lumen& lumen, Scene& scene);

/// True if a film along the path shows the wall by default: the lumen is known, and no keyframe has a
/// function.
bool showsWallByDefault(const Path& path);

} // namespace tessera

// bricking/analysis/lumen/smooth_line.h: polylines: even spacing, smoothing that keeps bends, and the radii
// of their turns.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Along the line, from its first point, mm.
std::vector<double> arcsOf(const std::vector<glm::dvec3>& line);

/// A Gaussian mean along the line, used three times, so that what it takes from a bend comes back: 1 - (1 -
/// G)^3. Bends over some deviations keep their place, ripples shorter than two go. Ends: as if the line went
/// on turned about them.
/// @param deviation  of the Gaussian at each point, in points; 0 leaves it
std::vector<glm::dvec3> smoothed(const std::vector<glm::dvec3>& line, const std::vector<double>& deviation);
/// A plain Gaussian mean along the line, ends as above.
std::vector<glm::dvec3> blurred(const std::vector<glm::dvec3>& line, const std::vector<double>& deviation);

/// Where on a line points lie evenly: as numbers of points and shares of the way to the next.
std::vector<double> evenPlaces(const std::vector<glm::dvec3>& line, double spacingMm);
/// On the Catmull-Rom curve through the points, or, straight, on the lines between them.
glm::dvec3 pointAt(const std::vector<glm::dvec3>& line, double place, bool straight);
/// Evenly along the Catmull-Rom curve: the most that are not further apart than spacingMm; two at least.
std::vector<glm::dvec3> evenly(const std::vector<glm::dvec3>& line, double spacingMm, bool straight,
                               double& spacing);

/// Of points that claim an even spacing, how far each is at least from the one before, as a share of it:
/// nearer together they lie in a kink. A path's reader takes 0.5 (core/animation/path.cpp).
constexpr double kLeastStep = 0.6;
bool stepsHold(const std::vector<glm::dvec3>& points, double spacingMm);

struct EvenSteps {
    std::vector<double> places; ///< on the line, as evenPlaces() has them, ascending
    std::vector<glm::dvec3> mm; ///< there, or on the chord over a kink
    double spacingMm = 0;
};
/// Evenly along straight lines between the points, so that stepsHold(). They are closer together than
/// spacingMm where the line bends, down to leastMm. What turns back within less than that is left out. Its
/// ends stay.
EvenSteps evenSteps(const std::vector<glm::dvec3>& line, double spacingMm, double leastMm);

/// Radius of the circle through a point and those `reach` before and after it, mm; infinite for a straight
/// line and near the ends.
double turnMm(const std::vector<glm::dvec3>& line, std::size_t point, std::size_t reach);

} // namespace tessera

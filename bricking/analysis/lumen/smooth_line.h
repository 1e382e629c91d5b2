// bricking/analysis/lumen/smooth_line.h: polylines: even spacing, smoothing that keeps bends, and the radii
// of their turns.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Along the line, from its first point, mm.
std::vector<double> arcsOf(const std::vector<glm::dvec3>& line);

/// A Gaussian mean G along the line, applied as 1 - (1 - G)^3, which restores bends. Bends over some
/// deviations keep their place, ripples shorter than two vanish. The line is extended beyond its ends by
/// point reflection.
/// @param deviation  of the Gaussian at each point, in points; 0: the point stays
std::vector<glm::dvec3> smoothed(const std::vector<glm::dvec3>& line, const std::vector<double>& deviation);
/// A plain Gaussian mean along the line, ends as above.
std::vector<glm::dvec3> blurred(const std::vector<glm::dvec3>& line, const std::vector<double>& deviation);

/// Evenly spaced positions on a line: index of a point plus the share of the way to the next.
std::vector<double> evenPlaces(const std::vector<glm::dvec3>& line, double spacingMm);
/// On the Catmull-Rom curve through the points or, if straight, on the lines between them.
glm::dvec3 pointAt(const std::vector<glm::dvec3>& line, double place, bool straight);
/// Evenly spaced points on the Catmull-Rom curve, at most spacingMm apart; two at least.
std::vector<glm::dvec3> evenly(const std::vector<glm::dvec3>& line, double spacingMm, bool straight,
                               double& spacing);

/// Least distance between points of nominally even spacing, as a share of it: nearer ones lie in a kink. A
/// path's reader accepts 0.5 (core/animation/path.cpp).
constexpr double kLeastStep = 0.6;
bool stepsHold(const std::vector<glm::dvec3>& points, double spacingMm);

struct EvenSteps {
    std::vector<double> places; ///< on the line, as by evenPlaces(), ascending
    std::vector<glm::dvec3> mm; ///< points there, or on the chord over a kink
    double spacingMm = 0;
};
/// Evenly spaced points on the straight lines between the points, such that stepsHold(). They are closer than
/// spacingMm where the line bends, down to leastMm. Shorter reversals are left out. The ends stay.
EvenSteps evenSteps(const std::vector<glm::dvec3>& line, double spacingMm, double leastMm);

/// Radius of the circle through a point and those `reach` before and after it, mm; infinite for a straight
/// line and near the ends.
double turnMm(const std::vector<glm::dvec3>& line, std::size_t point, std::size_t reach);

} // namespace tessera

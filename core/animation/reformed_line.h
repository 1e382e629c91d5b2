// core/animation/reformed_line.h: curved planar reformations of a line: straightened and stretched, as
// Kanitsar et al. (CPR: Curved Planar Reformation, IEEE Visualization 2002) name them.
#pragma once

#include "core/animation/flight.h"
#include "core/scene/reformation.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace tessera {

struct ReformedPixels {
    double widthMm = 40; // of a straightened picture; of a stretched one beyond the line's own extent
    double mmPerPixel = 1;
    int samples = 1; // along either side of a pixel
};

/// Straightened: the line runs down the middle of the picture, a row every mmPerPixel of its length. Rows lie
/// in the plane of the tangent and a vector at right angles to it, which turns about the tangent no more than
/// it must. The tangent is that over 8 mm: directions of centre-lines are noisier than their places. Rows are
/// marked as folded beyond the line's centre of curvature.
/// @param line     along its tangent: a flight without a look ahead
/// @param degrees  from the line's upper side, clockwise along the line, to the viewer. At its beginning that
///     side is the patient's front where the line lies within 45 degrees of the axis from feet to head, else
///     the head; so that a picture is none from behind
/// Throws InputError for more rows or columns than a picture may have.
Reformation straightened(const FlightCurve& line, double degrees, const ReformedPixels& pixels);

/// Stretched: the line, moved along a direction, sweeps out a surface; the picture is that surface laid flat.
/// Columns are mm along the direction, rows mm of the line's projection along it. So lengths and angles on
/// the surface are those of the picture, and the line has its own length there.
struct Stretched {
    Reformation picture;
    bool endOnTop = false; // the line's end, not its beginning
};
/// @param direction  of the columns, any length but 0: to the right
/// @param up         of the two ends the one that lies higher is on top
/// Throws InputError as straightened() does, and where all of the line runs along the direction.
Stretched stretched(const FlightCurve& line, const glm::dvec3& direction, const glm::dvec3& up,
                    const ReformedPixels& pixels);

/// The middles of so many equal parts of the line, mm from its beginning.
std::vector<double> sectionPlaces(const FlightCurve& line, int count);

/// A cross-section: the plane at right angles to the line, as wide as high, with the line in its middle. Its
/// rows run as those of straightened() there, the viewer of which is on top; its own viewer looks back along
/// the line, and a slab is thick along it.
/// @param mm  from the line's beginning
Reformation crossSection(const FlightCurve& line, double mm, double degrees, const ReformedPixels& pixels);

/// Bytes of the rows of a cross-section.
std::size_t sectionBytes(const ReformedPixels& pixels);

/// Bytes of the rows of one picture, and of what makes them, at most.
std::size_t reformedBytes(const FlightCurve& line, const ReformedPixels& pixels);

/// A digest of the line as it is drawn, 16 hexadecimal digits: the same of the same places.
std::string digestOf(const FlightCurve& line);

} // namespace tessera

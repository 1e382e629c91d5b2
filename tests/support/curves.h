// tests/support/curves.h: curves whose places are known in closed form, as lines that are flown along.
#pragma once

#include "core/animation/flight.h"
#include "core/animation/path.h"

#include <cmath>
#include <functional>
#include <glm/vec3.hpp>

namespace tessera::test {

/// A curve that is given by its length.
inline FlightCurve curveOf(double lengthMm, const std::function<glm::dvec3(double)>& at, double spacing = 1) {
    CentreLine line;
    const int count = static_cast<int>(std::lround(lengthMm / spacing)) + 1;
    line.spacingMm = lengthMm / (count - 1);
    for (int i = 0; i < count; ++i) {
        line.points.push_back(at(i * line.spacingMm));
        line.radiusMm.push_back(5);
    }
    Flight flight;
    flight.lookAheadMm = 0;
    return FlightCurve({line}, flight);
}

} // namespace tessera::test

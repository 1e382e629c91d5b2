// tests/bench/accuracy/stiff.h: the result of each integrator for extinction from 1e-6 to 1e6 per slab. The
// slab has constant extinction and a colour ramp (closed form T6), cut into 64 segments, by the same
// arithmetic as GPU ray caster and mirror.
#pragma once

#include <string>
#include <vector>

namespace tessera::accuracy {

struct StiffCurve {
    std::string name;                              // "midpoint, double"
    std::vector<std::pair<double, double>> points; // optical depth of the slab, relative error
};

constexpr int kStiffSegments = 64;
std::vector<StiffCurve> stiffCurves();

} // namespace tessera::accuracy

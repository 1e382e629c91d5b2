// tests/bench/accuracy/stiff.h: what each integrator makes of extinction from 1e-6 to 1e6 per slab: a slab
// of constant extinction whose colour is a ramp (closed form T6; NUMERICS B2), cut into 64 segments, by the
// very arithmetic that march and mirror use.
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

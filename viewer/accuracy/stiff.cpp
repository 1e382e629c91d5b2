// viewer/accuracy/stiff.cpp: see stiff.h.
#include "viewer/accuracy/stiff.h"

#include "render/optics.h"

#include <cmath>

namespace tessera::accuracy {
namespace {

constexpr double kFirst = 0.2, kLast = 0.9; // of the colour ramp

/// Closed form T6: c0 (1-e^-x) + (c1-c0) ((1-e^-x)/x - e^-x), the last by its series where it would cancel.
double exactColour(double x) {
    double ramp = -std::expm1(-x) / x - std::exp(-x);
    if (x < 0.5) {
        ramp = 0;
        double term = 1;
        for (int k = 1; k < 24; ++k) {
            term *= -x / (k + 1);
            ramp -= term * k;
        }
    }
    return kFirst * -std::expm1(-x) + (kLast - kFirst) * ramp;
}

template <typename Real> double midpointError(double depth) {
    const Real segment = static_cast<Real>(depth / kStiffSegments);
    Real colour = 0, alpha = 0;
    for (int i = 0; i < kStiffSegments; ++i) {
        const Real c = static_cast<Real>(kFirst + (kLast - kFirst) * (i + 0.5) / kStiffSegments);
        const Real weight = (Real(1) - alpha) * opacityOf(segment);
        alpha += weight;
        colour += weight * c;
    }
    const double exact = exactColour(depth);
    return std::abs(static_cast<double>(colour) - exact) / exact;
}

} // namespace

std::vector<StiffCurve> stiffCurves() {
    std::vector<StiffCurve> curves = {{"midpoint, double", {}}, {"midpoint, float", {}}};
    for (int quarter = -24; quarter <= 24; ++quarter) {
        const double depth = std::pow(10, 0.25 * quarter);
        curves[0].points.emplace_back(depth, midpointError<double>(depth));
        curves[1].points.emplace_back(depth, midpointError<float>(depth));
    }
    return curves;
}

} // namespace tessera::accuracy

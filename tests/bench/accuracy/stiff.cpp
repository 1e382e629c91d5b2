// tests/bench/accuracy/stiff.cpp: see stiff.h.
#include "tests/bench/accuracy/stiff.h"

#include "core/scene/scene.h" // integratorNames
#include "render/contract/integrators.h"

#include <cmath>

namespace tessera::accuracy {
namespace {

constexpr float kFirst = 0.2f, kLast = 0.9f; // of the colour ramp

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
    return double{kFirst} * -std::expm1(-x) + (double{kLast} - double{kFirst}) * ramp;
}

/// The slab as the integrators read it: a table of two entries, values from one to the other along the ray;
/// the slab is one millimetre long.
Optics slab(double depth, Integrator integrator) {
    const float extinction = static_cast<float>(depth);
    TransferTable table;
    table.firstValue = 0;
    table.entriesPerValue = 1;
    table.entries = {glm::vec4(glm::vec3(kFirst), extinction), glm::vec4(glm::vec3(kLast), extinction)};
    Shading unlit;
    unlit.on = false;
    Optics o = makeOptics(table, VolumeInfo{}, unlit, 0, integrator);
    preparePreintegration2d(o, 1.0 / kStiffSegments, 0, 1);
    return o;
}

template <typename Real> double relativeError(const Optics& o) {
    const Real length = Real(1) / Real(kStiffSegments);
    Real colour = 0, alpha = 0;
    for (int i = 0; i < kStiffSegments; ++i) {
        Real front = static_cast<Real>(i) * length, back = static_cast<Real>(i + 1) * length;
        if (!needsEnds(o.integrator))
            front = back = Real(0.5) * (front + back);
        const auto from = endOf(o, front), to = endOf(o, back);
        const Real depth = segmentExtinction(o, from, to) * length, opacity = opacityOf(depth);
        const Real weight = (Real(1) - alpha) * opacity;
        alpha += weight;
        colour += weight * segmentColour(o, from, to, depth, opacity, 1).r;
    }
    const double exact = exactColour(static_cast<double>(o.table.front().a));
    return std::abs(static_cast<double>(colour) - exact) / exact;
}

} // namespace

std::vector<StiffCurve> stiffCurves() {
    std::vector<StiffCurve> curves;
    for (const Integrator integrator :
         {Integrator::midpoint, Integrator::linear, Integrator::preintegrated, Integrator::preintegrated2d}) {
        const std::string& name = integratorNames()[static_cast<std::size_t>(integrator)];
        StiffCurve inDouble{name + ", double", {}}, inFloat{name + ", float", {}};
        for (int quarter = -24; quarter <= 24; ++quarter) {
            const Optics o = slab(std::pow(10, 0.25 * quarter), integrator);
            const double depth = std::pow(10, 0.25 * quarter);
            inDouble.points.emplace_back(depth, relativeError<double>(o));
            inFloat.points.emplace_back(depth, relativeError<float>(o));
        }
        curves.push_back(std::move(inDouble));
        curves.push_back(std::move(inFloat));
    }
    return curves;
}

} // namespace tessera::accuracy

// render/backends/reference/reference_proof.cpp: see reference_proof.h.
#include "render/backends/reference/reference_proof.h"

#include "core/base/threads.h"
#include "render/backends/reference/reference_integrator.h"
#include "render/backends/reference/simpson_ray.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

namespace tessera {
namespace {

template <typename F> ReferenceIntegrator over(double a, double b, const F& radiant) {
    ReferenceIntegrator integral;
    integral.add(a, b, radiant);
    return integral;
}
double relative(double computed, double exact) {
    return std::abs(computed - exact) / std::abs(exact);
}
constexpr double kTight = 1e-12, kLoose = 1e-10; // relative errors allowed

ClosedFormError constantSlab() {
    ClosedFormError e{"T1", "constant slab, optical depth 1e-6 to 1e6", 0, kTight};
    for (int decade = -6; decade <= 6; ++decade) {
        const double x = std::pow(10, decade), exact = -std::expm1(-x);
        const auto r = over(0, 1, [x](double) { return RadiantPoint{x, glm::dvec3(1)}; });
        e.relativeError =
            std::max({e.relativeError, relative(r.alpha(), exact), relative(r.colour().r, exact)});
    }
    return e;
}

ClosedFormError exponentialSlab() {
    ClosedFormError e{"T3", "exponential slab", 0, kTight};
    for (const double scale : {0.05, 0.2, 5.0}) {
        const double exact = 3 * scale * -std::expm1(-2 / scale);
        const auto r = over(0, 2, [scale](double t) {
            return RadiantPoint{3 * std::exp(-t / scale), glm::dvec3(1)};
        });
        e.relativeError = std::max(e.relativeError, relative(r.depth(), exact));
    }
    return e;
}

ClosedFormError sphereChords() {
    ClosedFormError e{"T4", "chords of a uniform sphere", 0, kTight};
    for (const double b : {0.0, 0.5, 1.0, 1.9, 1.999, 1.999999}) {
        const double half = std::sqrt(4 - b * b);
        const auto r = over(-half, half, [](double) { return RadiantPoint{0.7, glm::dvec3(0.5)}; });
        e.relativeError = std::max(e.relativeError, relative(r.alpha(), -std::expm1(-1.4 * half)));
    }
    return e;
}

ClosedFormError gaussianBlob() {
    ClosedFormError e{"T5", "Gaussian blob", 0, kTight};
    const double s = 0.3, h = 2;
    for (const double b : {0.0, 0.4, 1.0}) {
        const auto r = over(-h, h, [b, s](double t) {
            return RadiantPoint{5 * std::exp(-(t * t + b * b) / (2 * s * s)), glm::dvec3(1)};
        });
        const double exact = 5 * s * std::sqrt(2 * std::numbers::pi) * std::exp(-b * b / (2 * s * s)) *
                             std::erf(h / (s * std::numbers::sqrt2));
        e.relativeError = std::max(e.relativeError, relative(r.depth(), exact));
    }
    return e;
}

ClosedFormError colourRamp() {
    ClosedFormError e{"T6", "colour ramp, optical depth 1e-6 to 1e6", 0, kTight};
    for (int decade = -6; decade <= 6; ++decade) {
        const double x = std::pow(10, decade), c0 = 0.2, c1 = 0.9;
        const auto r = over(0, 1, [=](double t) { return RadiantPoint{x, glm::dvec3(c0 + (c1 - c0) * t)}; });
        double ramp = -std::expm1(-x) / x - std::exp(-x);
        if (x < 0.5) { // by its series, which does not cancel: sum of -(-x)^k k/(k+1)!
            ramp = 0;
            double term = 1;
            for (int k = 1; k < 24; ++k) {
                term *= -x / (k + 1);
                ramp -= term * k;
            }
        }
        e.relativeError =
            std::max(e.relativeError, relative(r.colour().r, c0 * -std::expm1(-x) + (c1 - c0) * ramp));
    }
    return e;
}

ClosedFormError stepFunction() {
    ClosedFormError e{"T7", "step function across a ramp, cut at the step", 0, kTight};
    const double s0 = 0.3721;
    for (const double sigma : {1e-3, 4.0, 1e3}) {
        const auto f = [=](double t) { return RadiantPoint{t < s0 ? 0 : sigma, glm::dvec3(1)}; };
        ReferenceIntegrator r;
        r.add(0, s0, f);
        r.add(s0, 1, f);
        e.relativeError = std::max(e.relativeError, relative(r.alpha(), -std::expm1(-sigma * (1 - s0))));
    }
    return e;
}

ClosedFormError linearTimesLinear() {
    ClosedFormError e{"T8", "extinction and colour linear across a ramp", 0, kLoose};
    for (const double kappa : {0.01, 1.0, 10.0, 1000.0}) {
        const auto r = over(0, 1, [kappa](double u) { return RadiantPoint{kappa * u, glm::dvec3(u)}; });
        const double exact =
            std::sqrt(std::numbers::pi / (2 * kappa)) * std::erf(std::sqrt(kappa / 2)) - std::exp(-kappa / 2);
        e.relativeError = std::max(e.relativeError, relative(r.colour().b, exact));
    }
    return e;
}

/// Error of the transmittance, for depths below the integrator's opaque limit.
ClosedFormError boundaryLayer() {
    ClosedFormError e{"T11", "boundary layer k/(t+eps), eps 1e-2 to 1e-8", 0, kLoose};
    for (const double eps : {1e-2, 1e-4, 1e-6, 1e-8})
        for (const double k : {0.1, 0.5, 1.0, 2.0}) {
            const auto r = over(0, 1, [=](double t) { return RadiantPoint{k / (t + eps), glm::dvec3(1)}; });
            const double depth = k * (std::log1p(eps) - std::log(eps));
            e.relativeError = std::max({e.relativeError, std::abs(std::expm1(depth - r.depth())),
                                        relative(r.alpha(), -std::expm1(-depth))});
        }
    return e;
}

ClosedFormError surfaceInMedium() {
    ClosedFormError e{"surface", "a surface inside a constant medium, optical depth 1e-6 to 1e3", 0, kTight};
    const double at = 0.37, opacity = 0.4, medium = 0.8, surface = 0.3;
    for (int decade = -6; decade <= 3; ++decade) {
        const double x = std::pow(10, decade);
        const auto radiant = [&](double) { return RadiantPoint{x, glm::dvec3(medium)}; };
        ReferenceIntegrator r;
        r.add(0, at, radiant);
        r.addSurface(glm::dvec3(surface), opacity);
        r.add(at, 1, radiant);
        const double before = std::exp(-x * at);
        const double colour =
            medium * -std::expm1(-x * at) +
            before * (opacity * surface - (1 - opacity) * medium * std::expm1(-x * (1 - at)));
        const double alpha = opacity - (1 - opacity) * std::expm1(-x);
        e.relativeError =
            std::max({e.relativeError, relative(r.colour().g, colour), relative(r.alpha(), alpha)});
    }
    return e;
}

double largestDifference(const std::vector<glm::dvec4>& a, const std::vector<glm::dvec4>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (int c = 0; c < 4; ++c) {
            const double d = std::abs(a[i][c] - b[i][c]);
            largest = std::isfinite(d) ? std::max(largest, d) : std::numeric_limits<double>::infinity();
        }
    return largest;
}

bool showsNothing(const TransferFunction& function) {
    return std::all_of(function.opacityPoints().begin(), function.opacityPoints().end(),
                       [](const OpacityPoint& p) { return p.opacity == 0; });
}

/// Half transparent from end to end of the volume, with another colour on each side of every surface.
TransferFunction fogAround(const std::vector<Isosurface>& surfaces, const VolumeInfo& info) {
    double lowest = surfaces.front().value, highest = lowest;
    for (const Isosurface& surface : surfaces) {
        lowest = std::min(lowest, surface.value);
        highest = std::max(highest, surface.value);
    }
    const double around = std::max(highest - lowest, std::abs(info.rescaleSlope));
    const glm::dvec3 diagonalMm = glm::dmat3(info.patientFromVoxel) * glm::dvec3(info.extentVoxels);
    return TransferFunction::fromExtinction(
        {{0, std::numbers::ln2 / glm::length(diagonalMm)}},
        {{lowest - around, {0, 0.3, 1}}, {highest + around, {1, 0.1, 0}}});
}

} // namespace

std::vector<ClosedFormError> closedFormErrors() {
    return {constantSlab(), exponentialSlab(),   sphereChords(),  gaussianBlob(),   colourRamp(),
            stepFunction(), linearTimesLinear(), boundaryLayer(), surfaceInMedium()};
}

RayProof proveOnRays(const ReferenceInput& scene, const std::vector<ReferenceRay>& rays, int threads) {
    ReferenceInput input = scene;
    TransferFunction fog;
    if (!scene.surfaces.empty() && showsNothing(*scene.function)) {
        fog = fogAround(scene.surfaces, *scene.info);
        input.function = &fog;
        input.shading.on = false;
    }
    // Light rays are verified by closed forms (tests/render/light/light_reference_test.cpp). The verification
    // here takes their results as given, because at the second integrator's density they would take too long.
    input.lighting.occlusion.reset();
    for (Light& light : input.lighting.lights)
        light.shadow = false;
    RayProof proof;
    proof.rays = rays.size();
    const std::vector<glm::dvec4> once = renderReference(input, rays, threads);
    ReferenceInput finer = input;
    finer.panels = 2 * input.panels;
    proof.halving = largestDifference(once, renderReference(finer, rays, threads));
    const Optics optics = shadingOf(input);
    std::vector<glm::dvec4> simpson(rays.size());
    parallelFor(rays.size(), threads, [&](std::size_t i) {
        LatticeReader samples(*input.cache, *input.info, 0, nullptr);
        simpson[i] = SimpsonRay(input, optics, samples)(rays[i]);
    });
    proof.independent = largestDifference(once, simpson);
    return proof;
}

std::vector<ReferenceRay> sampledRays(const std::vector<ReferenceRay>& rays, std::size_t count) {
    std::vector<ReferenceRay> sampled;
    for (std::size_t i = 0; i < std::min(count, rays.size()); ++i)
        sampled.push_back(rays[(2 * i + 1) * rays.size() / (2 * std::min(count, rays.size()))]);
    return sampled;
}

} // namespace tessera

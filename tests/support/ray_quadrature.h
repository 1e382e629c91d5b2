// tests/support/ray_quadrature.h: the integrators of the mirror on a line, without a volume: a field s(t) on
// [0,1], a transfer table, and the true integral of both beside them.
#pragma once

#include "render/backends/mirror/mirror.h"
#include "render/backends/reference/reference_integrator.h"

#include <algorithm>
#include <functional>
#include <glm/vec4.hpp>
#include <vector>

namespace tessera::test {

/// A field on [0,1], smooth between the given places.
struct LineField {
    std::function<double(double)> value;
    std::vector<double> breaks; // inside (0,1), ascending
};

/// A table over values [0,1], or of a function's points. Values are stored values.
inline TransferTable tableOf(const std::function<glm::dvec4(double)>& entry, int bins) {
    TransferTable table;
    table.firstValue = 0;
    table.entriesPerValue = static_cast<float>(bins);
    for (int i = 0; i <= bins; ++i)
        table.entries.emplace_back(entry(static_cast<double>(i) / bins));
    return table;
}

inline Optics lineOptics(const TransferTable& table, Integrator integrator, double segment) {
    VolumeInfo info;
    Shading off;
    off.on = false;
    Optics optics = makeOptics(table, info, off, 0, integrator);
    preparePreintegration2d(optics, segment, 0, 1);
    return optics;
}

/// What the mirror makes of n segments of a line of the given length.
template <typename Real>
glm::dvec4 integrate(const Optics& optics, const LineField& line, int n, double length = 1) {
    struct Field {
        const LineField& line;
        Real value(const glm::vec<3, Real>& p) const {
            return static_cast<Real>(line.value(static_cast<double>(p.x)));
        }
        glm::vec<3, Real> gradient(const glm::vec<3, Real>&, Gradient = {}) const {
            return glm::vec<3, Real>(0);
        }
        Real pitch(const glm::vec<3, Real>&) const { return 1; }
        leaf::LabelShares<Real> labels(const glm::vec<3, Real>&) const { return {}; }
        glm::vec<3, Real> mediumGradient(const glm::vec<3, Real>&) const { return glm::vec<3, Real>(0); }
        leaf::ReceivedLight<Real> received(const glm::vec<3, Real>&, const leaf::LightingNumbers&) const {
            return {};
        }
    } field{line};
    SegmentedRay<Real> ray;
    ray.step = {Real(1) / static_cast<Real>(n), 0, 0};
    ray.direction = {1, 0, 0};
    ray.segmentMm = static_cast<Real>(length / n);
    ray.count = n;
    MirrorInput input;
    input.optics = &optics;
    Work work;
    return glm::dvec4(mirrorRay<Real>(ray, field, input, work));
}

/// The true integral of the table as it is, cut wherever the field meets an entry: exact but for rounding.
inline glm::dvec4 trueIntegral(const Optics& optics, const LineField& line, double length = 1) {
    const auto place = [&](double t) {
        return line.value(t) * static_cast<double>(optics.scale) + static_cast<double>(optics.offset);
    };
    ReferenceIntegrator integral;
    const auto radiant = [&](double t) {
        const glm::dvec4 e = entryAt(optics, place(t));
        return RadiantPoint{e.a * length, glm::dvec3(e)};
    };
    const auto monotone = [&](double a, double b) { // between a and b the field rises or falls
        const double last = static_cast<double>(optics.table.size() - 1);
        const double from = std::clamp(place(a), 0.0, last), to = std::clamp(place(b), 0.0, last);
        const bool rising = to > from;
        double start = a;
        for (double entry = rising ? std::floor(from) + 1 : std::ceil(from) - 1;
             rising ? entry < to : entry > to; entry += rising ? 1 : -1) {
            double low = start, high = b;
            for (int turn = 0; turn < 60; ++turn) {
                const double middle = 0.5 * (low + high);
                ((place(middle) < entry) == rising ? low : high) = middle;
            }
            integral.add(start, high, radiant);
            start = high;
        }
        integral.add(start, b, radiant);
    };
    // Pieces so short that a smooth field is monotone on them, except for one turning point in some. There
    // the integrator's own bisection must find the entries that the field crosses twice.
    std::vector<double> cuts = line.breaks;
    constexpr int kPieces = 256;
    for (int i = 0; i <= kPieces; ++i)
        cuts.push_back(static_cast<double>(i) / kPieces);
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
        if (cuts[i + 1] > cuts[i])
            monotone(cuts[i], cuts[i + 1]);
    return {integral.colour(), integral.alpha()};
}

} // namespace tessera::test

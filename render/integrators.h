// render/integrators.h: what a segment of a ray adds (docs/sampling.md, "Integrators"): the C++ twin of
// shaders/march_segment.glsl. In float it repeats the shader operation by operation. "Place" is a value in
// units of the transfer table's entries; a segment is given by the places at its front and at its back, or,
// for the midpoint rule, by the place at its middle as both.
#pragma once

#include "render/optics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace tessera {

/// Beyond this, places stay; values that far outside of the table differ in nothing.
constexpr float kFarPlace = 4194304.0f; // 2^22

/// Whether segments need the field at their ends rather than at their middle.
constexpr bool needsEnds(Integrator integrator) {
    return integrator != Integrator::midpoint;
}

template <typename Real> Real placeOf(const Optics& o, Real stored) {
    const Real x = stored * static_cast<Real>(o.scale) + static_cast<Real>(o.offset);
    const Real above = x > Real(-kFarPlace) ? x : Real(-kFarPlace); // also where it is no number
    return above < Real(kFarPlace) ? above : Real(kFarPlace);
}

/// Colour and extinction at a place; constant beyond the table.
template <typename Real> glm::vec<4, Real> entryAt(const Optics& o, Real place) {
    const int last = static_cast<int>(o.table.size()) - 1;
    const Real x = std::clamp(place, Real(0), static_cast<Real>(last));
    const int i = std::min(static_cast<int>(x), last - 1);
    const glm::vec<4, Real> a(o.table[static_cast<std::size_t>(i)]),
        b(o.table[static_cast<std::size_t>(i) + 1]);
    return a + (x - static_cast<Real>(i)) * (b - a);
}

/// The bins that hold the ends of an interval of places; -1 is before the table, the last entry after it.
template <typename Real> struct PlaceInterval {
    Real low, high;
    int first, last;
    PlaceInterval(const Optics& o, Real front, Real back)
        : low(std::min(front, back)), high(std::max(front, back)), first(bin(o, low)), last(bin(o, high)) {}

  private:
    static int bin(const Optics& o, Real place) {
        return std::clamp(static_cast<int>(std::floor(place)), -1, static_cast<int>(o.table.size()) - 1);
    }
};

/// Integral from entry i to entry j, i <= j; from -1, before the table, to the number of entries, after it.
template <typename Real> glm::vec<4, Real> sumBetween(const Optics& o, int i, int j) {
    const auto high = [&](int n) { return glm::vec<4, Real>(o.sums[2 * static_cast<std::size_t>(n + 1)]); };
    const auto low = [&](int n) {
        return glm::vec<4, Real>(o.sums[2 * static_cast<std::size_t>(n + 1) + 1]);
    };
    return (high(j) - high(i)) + (low(j) - low(i));
}

/// Extinction, averaged over the values between two places; exact for the table. Zero exactly where every
/// entry around these values is zero.
template <typename Real> Real meanExtinction(const Optics& o, Real front, Real back) {
    const PlaceInterval<Real> p(o, front, back);
    if (p.first == p.last)
        return entryAt(o, Real(0.5) * (p.low + p.high)).a;
    if (sumBetween<Real>(o, p.first, p.last + 1).a == Real(0))
        return 0;
    const Real next = static_cast<Real>(p.first + 1), start = static_cast<Real>(p.last);
    const Real below = (next - p.low) * entryAt(o, Real(0.5) * (p.low + next)).a;
    const Real above = (p.high - start) * entryAt(o, Real(0.5) * (start + p.high)).a;
    return (below + sumBetween<Real>(o, p.first + 1, p.last).a + above) / (p.high - p.low);
}

/// Integral of extinction times colour, and of extinction, between places of one bin; Simpson's rule has it
/// exactly.
template <typename Real> glm::vec<4, Real> sumInsideBin(const Optics& o, Real low, Real high) {
    const auto radiance = [&](Real place) {
        const glm::vec<4, Real> e = entryAt(o, place);
        return glm::vec<4, Real>(e.r * e.a, e.g * e.a, e.b * e.a, e.a);
    };
    return ((high - low) * Real(1.0 / 6)) *
           (radiance(low) + Real(4) * radiance(Real(0.5) * (low + high)) + radiance(high));
}

/// Colour, averaged over the values between two places by their extinction.
template <typename Real> glm::vec<3, Real> meanColour(const Optics& o, Real front, Real back) {
    const PlaceInterval<Real> p(o, front, back);
    glm::vec<4, Real> sum(0);
    if (p.first == p.last)
        sum = sumInsideBin(o, p.low, p.high);
    else
        sum = sumInsideBin(o, p.low, static_cast<Real>(p.first + 1)) +
              sumBetween<Real>(o, p.first + 1, p.last) + sumInsideBin(o, static_cast<Real>(p.last), p.high);
    if (!(sum.a > Real(1e-30))) // the values hardly differ, or nothing shows
        return glm::vec<3, Real>(entryAt(o, Real(0.5) * (p.low + p.high)));
    return glm::vec<3, Real>(sum) / sum.a;
}

/// From the table of colours that are seen of segments of 2^k lattice segments, bilinear.
template <typename Real>
glm::vec<3, Real> seenColour(const Optics& o, Real front, Real back, int strideSegments) {
    const int edge = SeenColours::kEdge, layer = std::countr_zero(static_cast<unsigned>(strideSegments));
    const Real last = static_cast<Real>(static_cast<int>(o.table.size()) - 1);
    const Real scale = static_cast<Real>(o.seenScale);
    const Real x = std::clamp(front, Real(0), last) * scale, y = std::clamp(back, Real(0), last) * scale;
    const int i = std::min(static_cast<int>(x), edge - 2), j = std::min(static_cast<int>(y), edge - 2);
    const Real fx = x - static_cast<Real>(i), fy = y - static_cast<Real>(j);
    const auto at = [&](int column, int row) {
        const int n = ((layer - o.seen.firstLayer()) * edge + row) * edge + column;
        return glm::vec<3, Real>(glm::vec3(o.seen.colours()[static_cast<std::size_t>(n)]));
    };
    const glm::vec<3, Real> c00 = at(i, j), c10 = at(i + 1, j), c01 = at(i, j + 1), c11 = at(i + 1, j + 1);
    const glm::vec<3, Real> near = c00 + fx * (c10 - c00), far = c01 + fx * (c11 - c01);
    return near + fy * (far - near);
}

/// How far towards its back a segment of constant extinction is seen, in the mean over its light:
/// 1/x - 1/(e^x - 1), x its depth; phi_1's companion g(x) of NUMERICS B2, divided by 1 - e^-x.
template <typename Real> Real seenDepth(Real depth, Real alpha) {
    if (depth < Real(0.5)) {
        const Real s = depth * depth;
        return Real(0.5) -
               depth * (Real(1.0 / 12) -
                        s * (Real(1.0 / 720) -
                             s * (Real(1.0 / 30240) -
                                  s * (Real(1.0 / 1209600) -
                                       s * (Real(1.0 / 47900160) - s * Real(691.0 / 1307674368000))))));
    }
    return Real(1) / depth - (Real(1) - alpha) / alpha;
}

/// Extinction of a segment, per mm.
template <typename Real> Real segmentExtinction(const Optics& o, Real front, Real back) {
    switch (o.integrator) {
    case Integrator::linear:
        return Real(0.5) * (entryAt(o, front).a + entryAt(o, back).a);
    case Integrator::preintegrated:
    case Integrator::preintegrated2d:
        return meanExtinction(o, front, back);
    default:
        return entryAt(o, back).a;
    }
}

/// Colour that is seen of a segment of that depth and opacity, not premultiplied.
/// @param strideSegments  its length in lattice segments, before it is cut at the exit
template <typename Real>
glm::vec<3, Real> segmentColour(const Optics& o, Real front, Real back, Real depth, Real alpha,
                                int strideSegments) {
    using Vec = glm::vec<3, Real>;
    switch (o.integrator) {
    case Integrator::linear: {
        const Vec a(entryAt(o, front)), b(entryAt(o, back));
        return a + seenDepth(depth, alpha) * (b - a);
    }
    case Integrator::preintegrated:
        return meanColour(o, front, back);
    case Integrator::preintegrated2d:
        return seenColour(o, front, back, strideSegments);
    default:
        return Vec(entryAt(o, back));
    }
}

} // namespace tessera

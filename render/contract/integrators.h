// render/contract/integrators.h: the contribution of a ray's segment (docs/sampling.md, "Integrators"). In
// float shaders/march_segment.glsl gives the same bits, from the same leaves (leaves.h). "Place" is a value
// in units of the transfer table's entries. A segment is given by its two ends or, for the midpoint rule, by
// its middle as the back.
#pragma once

#include "render/contract/leaves.h"
#include "render/contract/optics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace tessera {

/// True if segments need the field at their ends rather than at their middle.
constexpr bool needsEnds(Integrator integrator) {
    return integrator != Integrator::midpoint;
}

/// Colour and extinction at a place; constant beyond the table.
template <typename Real> glm::vec<4, Real> entryAt(const Optics& o, Real place) {
    const int last = static_cast<int>(o.table.size()) - 1;
    return tableEntryAt(o, leaf::heldPlace(place, static_cast<Real>(last)));
}

/// One end of a segment: its place and, for pre-integration, the bin that holds it.
template <typename Real> struct SegmentEnd {
    Real place = 0;
    int bin = 0;                // -1 is before the table, its last entry after it
    glm::vec<4, Real> entry{0}; // of Optics::bins
};

template <typename Real> SegmentEnd<Real> endOf(const Optics& o, Real stored) {
    SegmentEnd<Real> end{placeOf(o, stored)};
    if (!o.bins.empty()) {
        end.bin =
            std::clamp(static_cast<int>(std::floor(end.place)), -1, static_cast<int>(o.table.size()) - 1);
        end.entry = glm::vec<4, Real>(o.bins[static_cast<std::size_t>(end.bin + 1)]);
    }
    return end;
}

/// The material of a segment: that of the value halfway between its ends.
template <typename Real>
leaf::Material<Real> materialOf(const Optics& o, const SegmentEnd<Real>& front,
                                const SegmentEnd<Real>& back) {
    return materialAt(o, needsEnds(o.integrator) ? Real(0.5) * (front.place + back.place) : back.place);
}

/// Extinction, averaged over the values between two ends; exact for the table but for rounding. Zero exactly
/// where every entry around these values is zero.
template <typename Real> Real meanExtinction(const SegmentEnd<Real>& front, const SegmentEnd<Real>& back) {
    const bool rises = front.place < back.place;
    const SegmentEnd<Real>&low = rises ? front : back, &high = rises ? back : front;
    const auto binEnd = [](const SegmentEnd<Real>& end) {
        const glm::vec<4, Real>& e = end.entry;
        return leaf::BinEnd<Real>{end.place, static_cast<Real>(end.bin), e.x, e.y, e.z, e.w};
    };
    return leaf::meanExtinction(binEnd(low), binEnd(high));
}

/// Colour, averaged over the values between two ends by their extinction; inside a bin the colour at the
/// middle of its used part.
template <typename Real>
glm::vec<3, Real> meanColour(const Optics& o, const SegmentEnd<Real>& front, const SegmentEnd<Real>& back) {
    const bool rises = front.place < back.place;
    const SegmentEnd<Real>&low = rises ? front : back, &high = rises ? back : front;
    const glm::vec<3, Real> middle(entryAt(o, Real(0.5) * (low.place + high.place)));
    if (low.bin == high.bin)
        return middle;
    const auto radiance = [&](Real width, Real place) {
        const glm::vec<4, Real> e = entryAt(o, place);
        const Real weight = width * e.a;
        return glm::vec<4, Real>(weight * e.r, weight * e.g, weight * e.b, weight);
    };
    const auto sumTo = [&](int entry, int part) {
        return glm::vec<4, Real>(
            o.sums[2 * static_cast<std::size_t>(entry + 1) + static_cast<std::size_t>(part)]);
    };
    const Real next = static_cast<Real>(low.bin + 1), start = static_cast<Real>(high.bin);
    const glm::vec<4, Real> below = radiance(next - low.place, Real(0.5) * (low.place + next));
    const glm::vec<4, Real> above = radiance(high.place - start, Real(0.5) * (start + high.place));
    const glm::vec<4, Real> from = sumTo(low.bin + 1, 0), fromRest = sumTo(low.bin + 1, 1);
    const glm::vec<4, Real> to = sumTo(high.bin, 0), toRest = sumTo(high.bin, 1);
    glm::vec<4, Real> sum(0);
    for (int c = 0; c < 4; ++c)
        sum[c] = leaf::sumOverBins(below[c], from[c], fromRest[c], to[c], toRest[c], above[c]);
    if (!(sum.a > Real(1e-30)))
        return middle; // nothing shows
    return glm::vec<3, Real>(sum) / sum.a;
}

/// From the table of colours that are seen of segments of 2^k lattice segments, bilinear.
template <typename Real>
glm::vec<3, Real> preintegratedColour(const Optics& o, Real front, Real back, int strideSegments) {
    const int edge = Preintegration2d::kEdge, layer = std::countr_zero(static_cast<unsigned>(strideSegments));
    const Real last = static_cast<Real>(static_cast<int>(o.table.size()) - 1);
    const Real scale = static_cast<Real>(o.preintegrationScale);
    const Real x = leaf::heldPlace(front, last) * scale, y = leaf::heldPlace(back, last) * scale;
    const int i = std::min(static_cast<int>(x), edge - 2), j = std::min(static_cast<int>(y), edge - 2);
    const Real fx = x - static_cast<Real>(i), fy = y - static_cast<Real>(j);
    const auto at = [&](int column, int row) {
        const int n = ((layer - o.seen.firstLayer()) * edge + row) * edge + column;
        return glm::vec<3, Real>(glm::vec3(o.seen.colours()[static_cast<std::size_t>(n)]));
    };
    return leaf::bilinear(at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1), fx, fy);
}

/// Extinction of a segment, per mm.
template <typename Real>
Real segmentExtinction(const Optics& o, const SegmentEnd<Real>& front, const SegmentEnd<Real>& back) {
    switch (o.integrator) {
    case Integrator::linear:
        return Real(0.5) * (entryAt(o, front.place).a + entryAt(o, back.place).a);
    case Integrator::preintegrated:
    case Integrator::preintegrated2d:
        return meanExtinction(front, back);
    default:
        return entryAt(o, back.place).a;
    }
}

/// Colour that is seen of a segment of that depth and opacity, not premultiplied.
/// @param strideSegments  its length in lattice segments, before it is cut at the exit
template <typename Real>
glm::vec<3, Real> segmentColour(const Optics& o, const SegmentEnd<Real>& front, const SegmentEnd<Real>& back,
                                Real depth, Real alpha, int strideSegments) {
    using Vec = glm::vec<3, Real>;
    switch (o.integrator) {
    case Integrator::linear: {
        const Vec a(entryAt(o, front.place)), b(entryAt(o, back.place));
        return leaf::partWay(a, b, leaf::seenDepth(depth, alpha));
    }
    case Integrator::preintegrated:
        return meanColour(o, front, back);
    case Integrator::preintegrated2d:
        return preintegratedColour(o, front.place, back.place, strideSegments);
    default:
        return Vec(entryAt(o, back.place));
    }
}

// Composites a colour behind a ray's colour so far (docs/sampling.md, "Ray"). By leaf::compositeBehind(), as
// everywhere.

/// @param sum     premultiplied colour and alpha before it
/// @param colour  not premultiplied, seen with opacity alpha
template <typename Real> void composite(glm::vec<4, Real>& sum, const glm::vec<3, Real>& colour, Real alpha) {
    glm::vec<3, Real> gathered(sum);
    leaf::compositeBehind(gathered, sum.a, colour, alpha);
    sum = {gathered, sum.a};
}

// The state of a ray that keeps one value, and its final colour (docs/sampling.md, "Modes").

/// The value that a ray has kept so far. Of the greatest and the least value it is the place in the table. Of
/// the mean it is the sum of values (stored units) by length, and the length (segments).
template <typename Real> struct KeptValue {
    Real kept = 0, length = 0;
    bool any = false; // it has met the drawn part
};

template <typename Real> KeptValue<Real> keepsNothing(const Optics& o) {
    KeptValue<Real> none;
    if (o.reduction == Reduction::minimum)
        none.kept = static_cast<Real>(o.table.size() - 1);
    return none;
}

/// Premultiplied: alpha 1 if the ray has met the drawn part of the volume.
template <typename Real> glm::vec<4, Real> colourOfKept(const Optics& o, const KeptValue<Real>& k) {
    if (!k.any)
        return glm::vec<4, Real>(0);
    const glm::vec<4, Real> colour =
        o.reduction == Reduction::average ? lookUp(o, k.kept / k.length) : tableEntryAt(o, k.kept);
    return {colour.r, colour.g, colour.b, Real(1)};
}

} // namespace tessera

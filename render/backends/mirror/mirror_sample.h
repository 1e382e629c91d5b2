// render/backends/mirror/mirror_sample.h: the visible part of a segment beside its values: labels, gradient
// opacity and light; counterpart of render/backends/native/packet_seen.h.
#pragma once

#include "core/base/work.h"
#include "render/contract/integrators.h"
#include "render/contract/optics.h"
#include "render/contract/sampler.h"

#include <cstdint>
#include <glm/vec3.hpp>

namespace tessera {

template <typename Real> struct SeenSegment {
    Real extinction = 0, opacity = 0; // per mm; of the segment
    glm::vec<3, Real> colour{0};      // not premultiplied
};

/// The gradient that is shaded.
template <typename Real, typename Field>
glm::vec<3, Real> normalGradient(const Optics& optics, Field& field, const glm::vec<3, Real>& p) {
    return optics.smooths() ? field.gradient(p, optics.normals) : field.gradient(p);
}

/// The segment between two ends, or around the second alone. False, and nothing is set, where it shows
/// nothing; its extinction may be 0 all the same.
/// @param field  gradient(p) and, with light and labels, received(), labels() and mediumGradient()
/// @param middle, direction  voxels
/// @param segments  its length in segments of the lattice, before it is cut at the exit
/// @param lit  colours are, where the scene is
template <typename Real, typename Field>
bool seeSegment(const Optics& optics, Field& field, const SegmentEnd<Real>& front,
                const SegmentEnd<Real>& back, const glm::vec<3, Real>& middle,
                const glm::vec<3, Real>& direction, Real lengthMm, int segments, Work& work,
                SeenSegment<Real>& seen, bool lit = true) {
    Real extinction = segmentExtinction(optics, front, back);
    LabelledSample<Real> labelled(optics, field, middle);
    if (!labelled.shows(extinction))
        return false;
    glm::vec<3, Real> gradient(0);
    const bool smooths = optics.shading && optics.smooths();
    if (optics.grades() || (optics.shading && !smooths)) {
        gradient = field.gradient(middle);
        work.samples += static_cast<std::uint64_t>(gradientValues(optics.gradient));
    }
    if (optics.grades())
        extinction *= gradientFactor(optics, gradient);
    if (smooths) {
        gradient = normalGradient(optics, field, middle);
        work.samples += static_cast<std::uint64_t>(gradientValues(optics.normals));
    }
    extinction = labelled.take(extinction);
    if (optics.shading && labelled.isMedium())
        gradient = field.mediumGradient(middle);
    const Real depth = extinction * lengthMm;
    seen.extinction = extinction;
    seen.opacity = opacityOf(depth);
    const glm::vec<3, Real> colour =
        labelled.colour(segmentColour(optics, front, back, depth, seen.opacity, segments));
    const auto material = [&] { return materialOf(optics, front, back); };
    seen.colour = lit ? seenColour(optics, colour, gradient, direction, middle, material, field) : colour;
    return true;
}

} // namespace tessera

// render/backends/mirror/mirror_places.h: where along a ray a path of light begins (docs/sampling.md,
// "Paths").
#pragma once

#include "render/backends/mirror/mirror_sample.h"
#include "render/transport/path_numbers.h" // exponentialOf

#include <algorithm>
#include <glm/vec3.hpp>

namespace tessera {

/// The place at which a ray has gathered an opacity; of rays that gather less, the last that shows something.
template <typename Real> struct SeenPlace {
    Real alpha = 0;     // sought
    bool parts = false; // it is sought in parts of its segment, too
    bool shows = false, found = false;
    Real share = 0;                        // where it is found: opacity of its segment in front of it
    int isosurface = -1;                   // that it is on, by number
    glm::vec<3, Real> place{0}, colour{0}; // voxels; not premultiplied
};

/// A part of a ray that shows something. True where it holds the place that is sought.
/// @param before  opacity in front of it
/// @param depth  optical, of its opacity; of an isosurface any
/// @param placeOf  of a share of the part, from 0 to 1: f(share)
template <typename Real, typename PlaceOf>
bool takePlace(Real before, Real opacity, Real depth, const glm::vec<3, Real>& colour, int isosurface,
               const PlaceOf& placeOf, SeenPlace<Real>& at) {
    // Not below 0 by rounding.
    const Real share = std::max(Real(0), (at.alpha - before) / (Real(1) - before)); // of opacity, up to it
    at.shows = true;
    at.found = share < opacity;
    at.share = share;
    at.colour = colour;
    at.isosurface = isosurface;
    at.place = placeOf(
        at.found ? std::min(Real(1), static_cast<Real>(exponentialOf(static_cast<float>(share))) / depth)
                 : Real(1));
    return at.found;
}

/// Seeks a place that takePlace() has found again, in parts of a stretch of the ray, by the midpoint rule in
/// each. It stays where it is if no part shows anything.
/// @param direction  voxels
/// @param lengthMm  of the stretch
/// @param passed  share of its opacity in front of the place
/// @param placeOf  of a share of it, from 0 to 1: f(share)
template <typename Real, typename Field, typename PlaceOf>
void seekInParts(const Optics& optics, Field& field, const glm::vec<3, Real>& direction, Real lengthMm,
                 Real passed, const PlaceOf& placeOf, Work& work, SeenPlace<Real>& at) {
    constexpr int kParts = leaf::kSoughtParts;
    constexpr Real kPart = Real(1) / kParts;
    SeenSegment<Real> parts[kParts];
    Real depths[kParts], depth = 0;
    for (int n = 0; n < kParts; ++n) {
        const glm::vec<3, Real> middle = placeOf((static_cast<Real>(n) + Real(0.5)) * kPart);
        const SegmentEnd<Real> end = endOf(optics, field.value(middle));
        seeSegment(optics, field, end, end, middle, direction, kPart * lengthMm, 1, work, parts[n], false);
        depths[n] = parts[n].extinction * (kPart * lengthMm);
        depth += depths[n];
    }
    work.samples += kParts;
    Real left = static_cast<Real>(exponentialOf(static_cast<float>(passed * opacityOf(depth))));
    for (int n = 0; n < kParts; ++n) {
        if (!(depths[n] > Real(0)))
            continue;
        at.place = placeOf((static_cast<Real>(n) + std::min(Real(1), left / depths[n])) * kPart);
        at.colour = parts[n].colour;
        if (left < depths[n])
            return;
        left -= depths[n];
    }
}

} // namespace tessera

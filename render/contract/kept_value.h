// render/contract/kept_value.h: the state of a ray that keeps one value, and its final colour
// (docs/sampling.md, "Modes").
#pragma once

#include "render/contract/optics.h"

#include <glm/vec4.hpp>

namespace tessera {

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

// render/contract/compositing.h: composites a colour under what a ray has gathered (docs/sampling.md, "Ray").
// The C++ twin of shaders/march_compositing.glsl, and the only place where the picture's
// colours are composited.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace tessera {

/// Front to back. The weight is what alpha really grew by: near 1 it no longer grows, and colour
/// must not either.
/// @param sum     premultiplied colour and alpha of what lies before
/// @param colour  not premultiplied, seen with opacity alpha
template <typename Real> void composite(glm::vec<4, Real>& sum, const glm::vec<3, Real>& colour, Real alpha) {
    const Real before = sum.a;
    sum.a = sum.a + (Real(1) - sum.a) * alpha; // exactly 1 where alpha is
    const Real weight = sum.a - before;
    sum.r = sum.r + weight * colour.r;
    sum.g = sum.g + weight * colour.g;
    sum.b = sum.b + weight * colour.b;
}

} // namespace tessera

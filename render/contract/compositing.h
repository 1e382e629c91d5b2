// render/contract/compositing.h: composites a colour behind a ray's colour so far (docs/sampling.md, "Ray").
// By leaf::compositeBehind(), as everywhere.
#pragma once

#include "render/contract/leaves.h"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace tessera {

/// @param sum     premultiplied colour and alpha before it
/// @param colour  not premultiplied, seen with opacity alpha
template <typename Real> void composite(glm::vec<4, Real>& sum, const glm::vec<3, Real>& colour, Real alpha) {
    glm::vec<3, Real> gathered(sum);
    leaf::compositeBehind(gathered, sum.a, colour, alpha);
    sum = {gathered, sum.a};
}

} // namespace tessera

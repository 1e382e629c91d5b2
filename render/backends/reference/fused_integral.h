// render/backends/reference/fused_integral.h: the integral along rays through several volumes
// (docs/sampling.md, "Several volumes"). A ray is cut at the planes of all of them; between two cuts each
// volume's extinction and colour are smooth.
#pragma once

#include "render/backends/reference/reference.h"

#include <glm/vec4.hpp>
#include <vector>

namespace tessera {

/// As renderReference().
/// @param input  with its lattice
std::vector<glm::dvec4> renderFused(const ReferenceInput& input, const std::vector<ReferenceRay>& rays,
                                    int threads);

} // namespace tessera

// bricking/analysis/lumen/directions.h: evenly spread directions.
#pragma once

#include <array>
#include <glm/vec3.hpp>

namespace tessera {

/// 42 unit vectors: the corners of an icosahedron and the middles of its edges. With each its opposite.
const std::array<glm::dvec3, 42>& directions42();

} // namespace tessera

// render/light/directions.h: directions spread evenly over the sphere: the middles of the faces of a
// tetrahedron, an octahedron or an icosahedron, whose faces are cut into four, again and again (course notes
// 6.1).
#pragma once

#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Whether a solid has so many faces: 4, 8 or 20 times a power of four.
bool isDirectionCount(int count);
/// Unit vectors; their sum is zero. Always the same ones for a count (checked: isDirectionCount()).
std::vector<glm::dvec3> sphereDirections(int count);

} // namespace tessera

// render/light/directions.h: directions spread over the sphere: the middles of the faces of a tetrahedron, an
// octahedron or an icosahedron. Faces are cut into four, again and again (course notes 6.1). Such faces are
// not of one size, so each direction stands for the part of the sphere that its face covers.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Whether a solid has so many faces: 4, 8 or 20 times a power of four.
bool isDirectionCount(int count);
struct SphereDirection {
    glm::dvec3 towards; // unit
    double part = 0;    // of the sphere that it stands for: equation 6.1's w_k over their number
};
/// Parts sum to 1, directions weighted by them to zero. Always the same ones for a count (checked:
/// isDirectionCount()).
std::vector<SphereDirection> sphereDirections(int count);

} // namespace tessera

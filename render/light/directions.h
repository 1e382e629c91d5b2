// render/light/directions.h: directions spread over the sphere: the centres of the faces of a tetrahedron, an
// octahedron or an icosahedron. Faces are subdivided into four repeatedly (course notes 6.1). Such faces
// differ in size, so each direction has the solid angle of its face as weight.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// True if a solid has this number of faces: 4, 8 or 20 times a power of four.
bool isDirectionCount(int count);
struct SphereDirection {
    glm::dvec3 towards; // unit
    double part = 0;    // its share of the sphere: w_k of equation 6.1 over their number
};
/// Parts sum to 1, directions weighted by them to zero. The same for the same count (checked:
/// isDirectionCount()).
std::vector<SphereDirection> sphereDirections(int count);

} // namespace tessera

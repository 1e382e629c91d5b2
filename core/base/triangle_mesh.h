// core/base/triangle_mesh.h: TriangleMesh: triangles by shared points, as readers give them.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

struct TriangleMesh {
    std::vector<glm::vec3> points;
    std::vector<glm::vec3> normals;    // a unit vector a point, or empty: the triangles' own
    std::vector<glm::uvec3> triangles; // numbers of points

    std::size_t bytes() const {
        return (points.size() + normals.size()) * sizeof(glm::vec3) + triangles.size() * sizeof(glm::uvec3);
    }
};

} // namespace tessera

// tests/support/mesh_shapes.h: meshes by formulas, and files of them.
#pragma once

#include "core/base/triangle_mesh.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace tessera::test {

/// A sphere of `rings` x 2 `rings` quads, its corners on it.
inline TriangleMesh sphereMesh(const glm::dvec3& centre, double radius, int rings, bool insideOut = false) {
    TriangleMesh mesh;
    const double pi = std::acos(-1.0);
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j < 2 * rings; ++j) {
            const double theta = pi * i / rings, phi = pi * j / rings;
            mesh.points.emplace_back(centre + radius * glm::dvec3(std::sin(theta) * std::cos(phi),
                                                                  std::sin(theta) * std::sin(phi),
                                                                  std::cos(theta)));
        }
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * 2 * rings + j % (2 * rings)); };
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        mesh.triangles.push_back(insideOut ? glm::uvec3(a, c, b) : glm::uvec3(a, b, c));
    };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < 2 * rings; ++j) {
            if (i > 0)
                add(at(i, j), at(i + 1, j), at(i, j + 1));
            if (i + 1 < rings)
                add(at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
        }
    return mesh;
}

/// Two triangles: corner, corner + a, corner + a + b, corner + b.
inline TriangleMesh quadMesh(const glm::dvec3& corner, const glm::dvec3& a, const glm::dvec3& b) {
    TriangleMesh mesh;
    for (const glm::dvec3& p : {corner, corner + a, corner + a + b, corner + b})
        mesh.points.emplace_back(p);
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

} // namespace tessera::test

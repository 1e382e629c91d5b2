// render/geometry/triangle_hit.h: where a ray meets a triangle, without gaps between triangles that share an
// edge. Source: Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection", in double. A ray exactly
// through a shared edge or corner meets one of the triangles around it: that which has the edge on its
// lower side, by the rule of rasterisers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace tessera {

/// A ray whose largest direction is its z axis; triangles are sheared so that it runs along that.
struct ShearedRay {
    glm::dvec3 origin{0};
    int x = 0, y = 1, z = 2; // axes
    double shearX = 0, shearY = 0, scale = 1;

    /// @param direction  not 0
    ShearedRay(const glm::dvec3& from, const glm::dvec3& direction) : origin(from) {
        const glm::dvec3 d(std::abs(direction.x), std::abs(direction.y), std::abs(direction.z));
        z = d.x > d.y ? (d.x > d.z ? 0 : 2) : (d.y > d.z ? 1 : 2);
        x = (z + 1) % 3;
        y = (x + 1) % 3;
        shearX = direction[x] / direction[z];
        shearY = direction[y] / direction[z];
        scale = 1 / direction[z];
    }
    /// Across the ray, and along it.
    glm::dvec3 sheared(const glm::vec3& p) const {
        const double along = static_cast<double>(p[z]) - origin[z];
        return {(static_cast<double>(p[x]) - origin[x]) - shearX * along,
                (static_cast<double>(p[y]) - origin[y]) - shearY * along, along};
    }
};

struct TriangleHit {
    double t = 0;        // along the ray's direction
    double u = 0, v = 0; // weights of the first and of the second corner
};

namespace triangle {

/// Twice the area that the ray sees between itself and an edge; changes its sign with the edge's direction,
/// exactly.
inline double side(const glm::dvec3& p, const glm::dvec3& q) {
    return q.x * p.y - q.y * p.x;
}
/// True of an edge or of its reverse, never of both.
inline bool owns(const glm::dvec3& p, const glm::dvec3& q) {
    const double x = q.x - p.x, y = q.y - p.y;
    return y > 0 || (y == 0 && x > 0);
}
inline bool within(double side, const glm::dvec3& p, const glm::dvec3& q, bool positive) {
    if (side == 0)
        return positive ? owns(p, q) : owns(q, p);
    return (side > 0) == positive;
}

} // namespace triangle

/// Two-sided; a triangle that the ray sees from its edge is not met.
inline bool meetTriangle(const ShearedRay& ray, const glm::vec3& first, const glm::vec3& second,
                         const glm::vec3& third, TriangleHit& hit) {
    const glm::dvec3 a = ray.sheared(first), b = ray.sheared(second), c = ray.sheared(third);
    const double u = triangle::side(b, c), v = triangle::side(c, a), w = triangle::side(a, b);
    if (std::min(std::min(u, v), w) < 0 && std::max(std::max(u, v), w) > 0)
        return false;
    const double area = u + v + w;
    if (!(area != 0))
        return false;
    const bool positive = area > 0;
    if (!triangle::within(u, b, c, positive) || !triangle::within(v, c, a, positive) ||
        !triangle::within(w, a, b, positive))
        return false;
    hit.u = u / area;
    hit.v = v / area;
    hit.t = ray.scale * ((u * a.z + v * b.z + w * c.z) / area);
    return true;
}

} // namespace tessera

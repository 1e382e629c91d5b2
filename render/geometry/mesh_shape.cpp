// render/geometry/mesh_shape.cpp: see mesh_shape.h.
#include "render/geometry/mesh_shape.h"

#include "core/base/error.h"
#include "render/geometry/triangle_hit.h"

#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// Points in the order in which triangles use them, without those that none uses: what a ray reads of a leaf
/// lies side by side.
void orderPoints(TriangleMesh& mesh) {
    constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> place(mesh.points.size(), kUnused);
    std::vector<glm::vec3> points, normals;
    points.reserve(mesh.points.size());
    normals.reserve(mesh.normals.size());
    for (glm::uvec3& triangle : mesh.triangles)
        for (int corner = 0; corner < 3; ++corner) {
            std::uint32_t& to = place[triangle[corner]];
            if (to == kUnused) {
                to = static_cast<std::uint32_t>(points.size());
                points.push_back(mesh.points[triangle[corner]]);
                if (!mesh.normals.empty())
                    normals.push_back(mesh.normals[triangle[corner]]);
            }
            triangle[corner] = to;
        }
    mesh.points = std::move(points);
    mesh.normals = std::move(normals);
}

} // namespace

MeshShape::MeshShape(TriangleMesh mesh, MemoryBudget& ram, const std::string& what) : mesh_(std::move(mesh)) {
    TESSERA_CHECK(mesh_.normals.empty() || mesh_.normals.size() == mesh_.points.size());
    for (const glm::uvec3& triangle : mesh_.triangles)
        TESSERA_CHECK(triangle.x < mesh_.points.size() && triangle.y < mesh_.points.size() &&
                      triangle.z < mesh_.points.size());
    {
        const Charge making = ram.charge(bytesFor(mesh_), what);
        tree_ = BoxTree(mesh_);
        std::vector<glm::uvec3> inOrder;
        inOrder.reserve(mesh_.triangles.size());
        for (const std::uint32_t number : tree_.order())
            inOrder.push_back(mesh_.triangles[number]);
        mesh_.triangles = std::move(inOrder);
        orderPoints(mesh_);
    }
    charge_ = ram.charge(mesh_.bytes() + tree_.bytes(), what);
}

glm::dvec3 MeshShape::planeOf(std::uint32_t place) const {
    const glm::uvec3& t = mesh_.triangles[place];
    const glm::dvec3 a(mesh_.points[t.x]), b(mesh_.points[t.y]), c(mesh_.points[t.z]);
    return glm::cross(b - a, c - a);
}

glm::dvec3 MeshShape::normalOf(std::uint32_t place, double u, double v) const {
    const glm::uvec3& t = mesh_.triangles[place];
    return u * glm::dvec3(mesh_.normals[t.x]) + v * glm::dvec3(mesh_.normals[t.y]) +
           (1 - u - v) * glm::dvec3(mesh_.normals[t.z]);
}

void MeshShape::forEachBall(const std::function<void(const glm::dvec3&, double)>& visit) const {
    for (const glm::uvec3& t : mesh_.triangles) // points of no triangle are not drawn
        for (int corner = 0; corner < 3; ++corner)
            visit(glm::dvec3(mesh_.points[t[corner]]), 0);
}

void MeshShape::forEachTriangle(std::size_t from, std::size_t to, double, const VisitTriangle& visit) const {
    for (std::size_t n = from; n < to; ++n) {
        const glm::vec3 &a = mesh_.points[mesh_.triangles[n].x], &b = mesh_.points[mesh_.triangles[n].y],
                        &c = mesh_.points[mesh_.triangles[n].z];
        if (a != b && b != c && c != a) // else it has no area, and no ray meets it
            visit(glm::dvec3(a), glm::dvec3(b), glm::dvec3(c));
    }
}

bool MeshShape::next(const ShapeRay& ray, const HitOrder& after, double most, const HitFilter& filter,
                     ShapeHit& hit) const {
    const ShearedRay sheared(ray.origin, ray.direction);
    HitOrder best{most, 0};
    double bestU = 0, bestV = 0;
    std::uint32_t bestPlace = 0;
    bool found = false;
    tree_.visit(ray, after.t, most, [&](std::uint32_t place) {
        const glm::uvec3& t = mesh_.triangles[place];
        TriangleHit met;
        if (!meetTriangle(sheared, mesh_.points[t.x], mesh_.points[t.y], mesh_.points[t.z], met))
            return best.t;
        const HitOrder at{met.t, tree_.order()[place]};
        if (after < at && at < best && filter(met.t)) {
            best = at;
            bestU = met.u;
            bestV = met.v;
            bestPlace = place;
            found = true;
        }
        return best.t;
    });
    if (found)
        hit = mesh_.normals.empty() ? ShapeHit{best, planeOf(bestPlace)}
                                    : ShapeHit{best, normalOf(bestPlace, bestU, bestV), planeOf(bestPlace)};
    return found;
}

} // namespace tessera

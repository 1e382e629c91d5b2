// render/geometry/mesh_shape.h: MeshShape: triangles that rays meet, two-sided, closed or not.
#pragma once

#include "core/base/budget.h"
#include "core/base/triangle_mesh.h"
#include "render/geometry/box_tree.h"
#include "render/geometry/shape.h"

namespace tessera {

class MeshShape : public Shape {
  public:
    /// @param mesh  in patient space, mm; finite points, numbers of points within (checked)
    /// @param what  for the message of a budget that is too small
    MeshShape(TriangleMesh mesh, MemoryBudget& ram, const std::string& what);

    bool next(const ShapeRay& ray, const HitOrder& after, double most, const HitFilter& filter,
              ShapeHit& hit) const override;
    const ShapeBox& box() const override { return tree_.box(); }
    void forEachTriangle(std::size_t from, std::size_t to, double within,
                         const VisitTriangle& visit) const override;
    void forEachBall(const std::function<void(const glm::dvec3&, double)>& visit) const override;
    std::size_t parts() const override { return mesh_.triangles.size(); }
    const char* partName() const override { return "triangles"; }
    std::size_t bytes() const override { return charge_.bytes(); }

    /// RAM that making one takes, the mesh itself included.
    static std::size_t bytesFor(const TriangleMesh& mesh) {
        return mesh.bytes() + mesh.triangles.size() * sizeof(glm::uvec3) +
               BoxTree::bytesFor(mesh.triangles.size());
    }

  private:
    glm::dvec3 planeOf(std::uint32_t place) const;
    glm::dvec3 normalOf(std::uint32_t place, double u, double v) const;

    TriangleMesh mesh_; // triangles in the order of the tree
    BoxTree tree_;
    Charge charge_;
};

} // namespace tessera

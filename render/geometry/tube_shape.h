// render/geometry/tube_shape.h: TubeShape: a tube around a line as a closed form: the union of a capsule
// (cylinder with half spheres at its ends) around each piece of the line; a ball around a single point.
#pragma once

#include "core/base/budget.h"
#include "core/scene/mesh.h"
#include "render/geometry/shape.h"

#include <vector>

namespace tessera {

class TubeShape : public Shape {
  public:
    TubeShape(Tube tube, MemoryBudget& ram);

    /// The surface of the union: where capsules overlap there is none inside.
    bool next(const ShapeRay& ray, const HitOrder& after, double most, const HitFilter& filter,
              ShapeHit& hit) const override;
    const ShapeBox& box() const override { return box_; }
    void forEachBall(const std::function<void(const glm::dvec3&, double)>& visit) const override;
    std::size_t parts() const override { return pieces(); }
    std::size_t bytes() const override { return charge_.bytes(); }

  private:
    struct Span {
        double from, to;
        std::uint32_t first, last; // pieces at its ends
    };
    std::size_t pieces() const { return tube_.points.size() > 1 ? tube_.points.size() - 1 : 1; }
    bool meet(const ShapeRay& ray, std::uint32_t piece, Span& span) const;
    glm::dvec3 normalAt(const glm::dvec3& point, std::uint32_t piece) const;

    Tube tube_;
    std::vector<ShapeBox> boxes_; // around kOfBox pieces each
    ShapeBox box_;
    Charge charge_;
};

} // namespace tessera

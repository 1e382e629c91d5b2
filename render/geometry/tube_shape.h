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
    /// Of several lines that share a radius: one surface, without parts inside of one another.
    /// @param ends  of each line, one past its last point, ascending from 1 on; the last one is that of the
    ///              points (checked)
    TubeShape(Tube tube, const std::vector<std::uint32_t>& ends, MemoryBudget& ram);

    /// The surface of the union: where capsules overlap there is none inside.
    bool next(const ShapeRay& ray, const HitOrder& after, double most, const HitFilter& filter,
              ShapeHit& hit) const override;
    const ShapeBox& box() const override { return box_; }
    void forEachTriangle(std::size_t from, std::size_t to, double within,
                         const VisitTriangle& visit) const override;
    void forEachBall(const std::function<void(const glm::dvec3&, double)>& visit) const override;
    std::size_t parts() const override { return pieces_.size(); }
    const char* partName() const override { return "pieces of lines"; }
    std::size_t bytes() const override { return charge_.bytes(); }

  private:
    struct Span {
        double from, to;
        std::uint32_t first, last; // pieces at its ends
    };
    struct Piece {
        std::uint32_t from, to; // numbers of points; the same: a ball
    };
    /// Appends the spans of the pieces in a box.
    void collect(const ShapeRay& ray, std::size_t level, std::size_t box, std::vector<Span>& spans) const;
    bool meet(const ShapeRay& ray, std::uint32_t piece, Span& span) const;
    glm::dvec3 normalAt(const glm::dvec3& point, std::uint32_t piece) const;

    Tube tube_;
    std::vector<Piece> pieces_;
    std::vector<std::vector<ShapeBox>> boxes_; // around kOfBox pieces each, then around kOfBox boxes each
    ShapeBox box_;
    Charge charge_;
};

} // namespace tessera

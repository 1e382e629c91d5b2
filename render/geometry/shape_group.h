// render/geometry/shape_group.h: ShapeGroup: several shapes as one, each with a colour of its own or none.
#pragma once

#include "core/base/budget.h"
#include "render/geometry/shape.h"

#include <memory>
#include <optional>
#include <vector>

namespace tessera {

class ShapeGroup : public Shape {
  public:
    struct Member {
        std::unique_ptr<const Shape> shape;
        std::optional<glm::dvec3> colour = {}; // linear light
    };
    /// @param members  one at least, of less than 2^32 parts together (checked); they have charged their own
    explicit ShapeGroup(std::vector<Member> members);

    /// Hits of one place come in the order of the members.
    bool next(const ShapeRay& ray, const HitOrder& after, double most, const HitFilter& filter,
              ShapeHit& hit) const override;
    const ShapeBox& box() const override { return box_; }
    void forEachTriangle(std::size_t from, std::size_t to, double within,
                         const VisitTriangle& visit) const override;
    void forEachBall(const std::function<void(const glm::dvec3&, double)>& visit) const override;
    std::size_t parts() const override { return firstPart_.back(); }
    const char* partName() const override { return members_.front().shape->partName(); }
    std::size_t bytes() const override;

  private:
    std::vector<Member> members_;
    std::vector<std::uint32_t> firstPart_; // of each member; then the number of parts
    ShapeBox box_;
};

} // namespace tessera

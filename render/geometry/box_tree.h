// render/geometry/box_tree.h: BoxTree: boxes around triangles, four children a node, so that a ray tests only
// the triangles near it. The tree decides about speed alone: boxes are tested in float with a margin that
// holds all of rounding, so no hit is missed, and hits are computed in double elsewhere.
#pragma once

#include "core/base/triangle_mesh.h"
#include "render/geometry/shape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

class BoxTree {
  public:
    static constexpr std::uint32_t kMostOfLeaf = 4; // triangles

    BoxTree() = default;
    explicit BoxTree(const TriangleMesh& mesh);

    /// RAM of a tree and of what its making takes, at most.
    static std::size_t bytesFor(std::size_t triangles);
    std::size_t bytes() const {
        return nodes_.capacity() * sizeof(Node) + order_.capacity() * sizeof(std::uint32_t);
    }
    const ShapeBox& box() const { return box_; }

    /// Visits triangles whose boxes the ray meets in (least, most), near boxes first.
    /// @param visit  f(triangle) -> most from then on
    template <typename Visit>
    void visit(const ShapeRay& ray, double least, double most, const Visit& visit) const;

  private:
    using F4 = float __attribute__((vector_size(16)));
    using I4 = std::int32_t __attribute__((vector_size(16)));
    struct Node {
        F4 low[3], high[3];          // of four children; low > high: there is none
        std::uint32_t first[4] = {}; // node, or first of order_
        std::uint32_t count[4] = {}; // of a leaf's triangles; 0: a node
    };
    struct Maker;

    static F4 all(float v) { return F4{v, v, v, v}; }
    static F4 least4(F4 a, F4 b) { return a < b ? a : b; }
    static F4 most4(F4 a, F4 b) { return a > b ? a : b; }

    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_; // triangles
    ShapeBox box_;
    float reach_ = 0; // largest coordinate
};

template <typename Visit>
void BoxTree::visit(const ShapeRay& ray, double least, double most, const Visit& visit) const {
    if (nodes_.empty())
        return;
    // Rounding moves a box's plane by less than 2^-20 of the largest number in play.
    float reach = reach_;
    for (int axis = 0; axis < 3; ++axis)
        reach = std::max(reach, static_cast<float>(std::abs(ray.origin[axis])));
    const float margin = reach * 0x1p-20f;
    F4 inverse[3], towards[3], from[3]; // origin as seen by near and far planes
    bool rises[3];
    for (int axis = 0; axis < 3; ++axis) {
        constexpr double kSteepest = 1e-18; // finite and never 0/0: across such a direction nothing moves
        const double d = ray.direction[axis];
        rises[axis] = !(d < 0);
        const double held = rises[axis] ? std::max(d, kSteepest) : std::min(d, -kSteepest);
        inverse[axis] = all(static_cast<float>(1 / held));
        const float o = static_cast<float>(ray.origin[axis]);
        towards[axis] = all(rises[axis] ? o + margin : o - margin);
        from[axis] = all(rises[axis] ? o - margin : o + margin);
    }
    const auto below = [](double t) { return static_cast<float>(t - 1e-6 * std::abs(t)); };
    const auto above = [](double t) {
        return t > 1e30 ? 1e30f : static_cast<float>(t + 1e-6 * std::abs(t));
    };
    const float begin = below(std::max(least, -1e30));
    float end = above(most);
    struct Entry {
        std::uint32_t first, count;
        float near;
    };
    Entry stack[256]; // three a level; a tree has at most 80 (Maker)
    int depth = 0;
    stack[depth++] = {0, 0, begin};
    while (depth > 0) {
        const Entry entry = stack[--depth];
        if (entry.near > end)
            continue;
        if (entry.count > 0) {
            for (std::uint32_t n = 0; n < entry.count; ++n)
                most = std::min(most, visit(order_[entry.first + n]));
            end = above(most);
            continue;
        }
        const Node& node = nodes_[entry.first];
        F4 near = all(begin), far = all(end);
        for (int axis = 0; axis < 3; ++axis) {
            const F4 a = ((rises[axis] ? node.low : node.high)[axis] - towards[axis]) * inverse[axis];
            const F4 b = ((rises[axis] ? node.high : node.low)[axis] - from[axis]) * inverse[axis];
            near = most4(near, a);
            far = least4(far, b);
        }
        const I4 meets = near <= far;
        const int first = depth;
        for (int n = 0; n < 4; ++n) {
            if (!meets[n])
                continue;
            const Entry child{node.first[n], node.count[n], near[n]};
            int at = depth++;
            for (; at > first && stack[at - 1].near < child.near; --at) // the nearest comes off first
                stack[at] = stack[at - 1];
            stack[at] = child;
        }
    }
}

} // namespace tessera

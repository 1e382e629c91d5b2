// render/geometry/box_tree.h: BoxTree: boxes around triangles, four children a node, so that a ray tests only
// the triangles near it. The tree decides about speed alone: boxes are tested in float with a margin that
// holds all of rounding, so no hit is missed, and hits are computed in double elsewhere.
#pragma once

#include "core/base/triangle_mesh.h"
#include "render/geometry/shape.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
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

    /// The triangles in the order of the tree: those of a leaf one after another.
    const std::vector<std::uint32_t>& order() const { return order_; }

    /// Visits triangles whose boxes the ray meets in (least, most), near boxes first.
    /// @param visit  f(place in order()) -> most from then on
    template <typename Visit>
    void visit(const ShapeRay& ray, double least, double most, const Visit& visit) const;

  private:
    using F4 = float __attribute__((vector_size(16)));
    using I4 = std::int32_t __attribute__((vector_size(16)));
    struct Node {
        F4 planes[6]; // of four children's boxes: low x, y, z, high x, y, z; low > high: there is none
        std::uint32_t first[4] = {}; // node, or first of order_
        std::uint32_t count[4] = {}; // of a leaf's triangles; 0: a node
    };
    struct Maker;

    /// A bit for each that is true.
    static unsigned bitsOf(I4 which) {
#if defined(__SSE2__)
        return static_cast<unsigned>(__builtin_ia32_movmskps(reinterpret_cast<F4>(which)));
#else
        return (which[0] & 1u) | (which[1] & 2u) | (which[2] & 4u) | (which[3] & 8u);
#endif
    }
    static F4 all(float v) {
        return F4{v, v, v, v};
    }
    static F4 least4(F4 a, F4 b) {
        return a < b ? a : b;
    }
    static F4 most4(F4 a, F4 b) {
        return a > b ? a : b;
    }

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
    int nearPlanes[3];
    for (int axis = 0; axis < 3; ++axis) {
        constexpr double kSteepest = 1e-18; // finite and never 0/0: across such a direction nothing moves
        const double d = ray.direction[axis];
        const bool rises = !(d < 0);
        nearPlanes[axis] = rises ? axis : axis + 3;
        const double held = rises ? std::max(d, kSteepest) : std::min(d, -kSteepest);
        inverse[axis] = all(static_cast<float>(1 / held));
        const float o = static_cast<float>(ray.origin[axis]);
        towards[axis] = all(rises ? o + margin : o - margin);
        from[axis] = all(rises ? o - margin : o + margin);
    }
    const auto below = [](double t) { return static_cast<float>(t - 1e-6 * std::abs(t)); };
    const auto above = [](double t) { return t > 1e30 ? 1e30f : static_cast<float>(t + 1e-6 * std::abs(t)); };
    const float begin = below(std::max(least, -1e30));
    float end = above(most);
    struct Entry {
        std::uint32_t first, count;
        float near;
    };
    Entry stack[256]; // three a level; a tree has at most 80 (Maker)
    int depth = 0;
    Entry entry{0, 0, begin};
    const auto another = [&] { // of those that were put aside, the nearest that is left
        while (depth > 0) {
            entry = stack[--depth];
            if (entry.near <= end)
                return true;
        }
        return false;
    };
    for (;;) {
        if (entry.count > 0) {
            for (std::uint32_t n = 0; n < entry.count; ++n)
                most = std::min(most, visit(entry.first + n));
            end = above(most);
            if (!another())
                return;
            continue;
        }
        const Node& node = nodes_[entry.first];
        F4 near = all(begin), far = all(end);
        for (int axis = 0; axis < 3; ++axis) {
            const int plane = nearPlanes[axis], opposite = plane < 3 ? plane + 3 : plane - 3;
            near = most4(near, (node.planes[plane] - towards[axis]) * inverse[axis]);
            far = least4(far, (node.planes[opposite] - from[axis]) * inverse[axis]);
        }
        unsigned meets = bitsOf(near <= far);
        if (meets == 0) {
            if (!another())
                return;
            continue;
        }
        alignas(16) float nears[4];
        std::memcpy(nears, &near, sizeof nears);
        const auto childOf = [&](int n) { return Entry{node.first[n], node.count[n], nears[n]}; };
        entry = childOf(std::countr_zero(meets));
        const int first = depth;
        for (meets &= meets - 1; meets != 0; meets &= meets - 1) {
            Entry child = childOf(std::countr_zero(meets));
            if (child.near < entry.near)
                std::swap(child, entry);
            int at = depth++;
            for (; at > first && stack[at - 1].near < child.near; --at) // the nearest comes off first
                stack[at] = stack[at - 1];
            stack[at] = child;
        }
    }
}

} // namespace tessera

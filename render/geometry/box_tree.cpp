// render/geometry/box_tree.cpp: see box_tree.h. The tree is made from its root, each node split where the
// areas of both halves times their triangles are least, by bins of their middles (Wald 2007, "On fast
// Construction of SAH-based Bounding Volume Hierarchies"). Two levels of halves make one of quarters.
#include "render/geometry/box_tree.h"

#include "core/base/error.h"

#include <array>
#include <limits>
#include <numeric>

namespace tessera {
namespace {

constexpr int kBins = 16;
constexpr int kDeepest = 60; // levels; deeper nodes are split in the middle: at most 16 more

struct FloatBox {
    glm::vec3 low{std::numeric_limits<float>::max()}, high{-std::numeric_limits<float>::max()};
    void add(const glm::vec3& p) {
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis]);
            high[axis] = std::max(high[axis], p[axis]);
        }
    }
    void add(const FloatBox& b) {
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], b.low[axis]);
            high[axis] = std::max(high[axis], b.high[axis]);
        }
    }
    float area() const {
        if (!(high.x >= low.x))
            return 0;
        const glm::vec3 d = high - low;
        return d.x * d.y + d.y * d.z + d.z * d.x;
    }
};

} // namespace

struct BoxTree::Maker {
    struct Range {
        std::uint32_t first = 0, count = 0;
        FloatBox box;
    };

    const TriangleMesh& mesh;
    BoxTree& tree;
    std::vector<FloatBox> boxes; // of triangles

    Maker(const TriangleMesh& m, BoxTree& t) : mesh(m), tree(t), boxes(m.triangles.size()) {
        for (std::size_t n = 0; n < boxes.size(); ++n)
            for (int corner = 0; corner < 3; ++corner)
                boxes[n].add(m.points[m.triangles[n][corner]]);
    }
    glm::vec3 middle(std::uint32_t triangle) const {
        return 0.5f * boxes[triangle].low + 0.5f * boxes[triangle].high;
    }
    Range ranged(std::uint32_t first, std::uint32_t count) const {
        Range range{first, count, {}};
        for (std::uint32_t n = first; n < first + count; ++n)
            range.box.add(boxes[tree.order_[n]]);
        return range;
    }

    /// In two, at the best of the planes between bins; in the middle of the list where there is none.
    std::array<Range, 2> halves(const Range& range, bool simply) const {
        FloatBox middles;
        for (std::uint32_t n = range.first; n < range.first + range.count; ++n)
            middles.add(middle(tree.order_[n]));
        int bestAxis = -1, bestBin = 0;
        float best = std::numeric_limits<float>::max();
        for (int axis = 0; axis < 3 && !simply; ++axis) {
            const float width = middles.high[axis] - middles.low[axis];
            if (!(width > 0))
                continue;
            std::array<FloatBox, kBins> bins;
            std::array<std::uint32_t, kBins> counts{};
            for (std::uint32_t n = range.first; n < range.first + range.count; ++n) {
                const std::uint32_t triangle = tree.order_[n];
                const auto bin = static_cast<std::size_t>(binOf(middle(triangle)[axis], middles, axis));
                bins[bin].add(boxes[triangle]);
                ++counts[bin];
            }
            std::array<float, kBins> cost{};
            FloatBox grown;
            std::uint32_t count = 0;
            for (std::size_t bin = kBins - 1; bin > 0; --bin) {
                grown.add(bins[bin]);
                count += counts[bin];
                cost[bin] = grown.area() * static_cast<float>(count);
            }
            grown = FloatBox();
            count = 0;
            for (std::size_t bin = 1; bin < kBins; ++bin) {
                grown.add(bins[bin - 1]);
                count += counts[bin - 1];
                const float total = cost[bin] + grown.area() * static_cast<float>(count);
                if (count > 0 && count < range.count && total < best) {
                    best = total;
                    bestAxis = axis;
                    bestBin = static_cast<int>(bin);
                }
            }
        }
        std::uint32_t left = range.count / 2;
        if (bestAxis >= 0) {
            const auto begin = tree.order_.begin() + static_cast<std::ptrdiff_t>(range.first);
            const auto split = std::partition(
                begin, begin + static_cast<std::ptrdiff_t>(range.count), [&](std::uint32_t triangle) {
                    return binOf(middle(triangle)[bestAxis], middles, bestAxis) < bestBin;
                });
            left = static_cast<std::uint32_t>(split - begin);
        }
        return {ranged(range.first, left), ranged(range.first + left, range.count - left)};
    }
    static int binOf(float at, const FloatBox& middles, int axis) {
        const float share = (at - middles.low[axis]) / (middles.high[axis] - middles.low[axis]);
        return std::clamp(static_cast<int>(share * static_cast<float>(kBins)), 0, kBins - 1);
    }

    /// Returns the node's number.
    std::uint32_t make(const Range& range, int level) {
        const bool simply = level > kDeepest;
        std::vector<Range> parts{range};
        while (parts.size() < 4) {
            std::size_t largest = parts.size();
            for (std::size_t n = 0; n < parts.size(); ++n)
                if (parts[n].count > kMostOfLeaf &&
                    (largest == parts.size() || parts[n].count > parts[largest].count))
                    largest = n;
            if (largest == parts.size())
                break;
            const std::array<Range, 2> two = halves(parts[largest], simply);
            parts[largest] = two[0];
            parts.push_back(two[1]);
        }
        const auto number = static_cast<std::uint32_t>(tree.nodes_.size());
        tree.nodes_.emplace_back();
        for (int axis = 0; axis < 3; ++axis) {
            tree.nodes_[number].planes[axis] = all(std::numeric_limits<float>::max());
            tree.nodes_[number].planes[axis + 3] = all(-std::numeric_limits<float>::max());
        }
        for (std::size_t n = 0; n < parts.size(); ++n) {
            const Range& part = parts[n];
            const bool leaf = part.count <= kMostOfLeaf;
            const std::uint32_t first = leaf ? part.first : make(part, level + 1);
            Node& node = tree.nodes_[number]; // anew: the list has grown
            node.first[n] = first;
            node.count[n] = leaf ? part.count : 0;
            for (int axis = 0; axis < 3; ++axis) {
                node.planes[axis][n] = part.box.low[axis];
                node.planes[axis + 3][n] = part.box.high[axis];
            }
        }
        return number;
    }
};

BoxTree::BoxTree(const TriangleMesh& mesh) : order_(mesh.triangles.size()) {
    TESSERA_CHECK(mesh.triangles.size() < (std::size_t{1} << 31));
    if (order_.empty())
        return;
    std::iota(order_.begin(), order_.end(), 0u);
    nodes_.reserve(order_.size() / 3 + 1); // a node takes three triangles from the others at least
    Maker maker(mesh, *this);
    const Maker::Range whole = maker.ranged(0, static_cast<std::uint32_t>(order_.size()));
    maker.make(whole, 0);
    nodes_.shrink_to_fit();
    box_.add(glm::dvec3(whole.box.low));
    box_.add(glm::dvec3(whole.box.high));
    for (int axis = 0; axis < 3; ++axis)
        reach_ = std::max({reach_, std::abs(whole.box.low[axis]), std::abs(whole.box.high[axis])});
}

std::size_t BoxTree::bytesFor(std::size_t triangles) {
    // Nodes as reserved and once more as shrunk.
    return triangles * (sizeof(FloatBox) + sizeof(std::uint32_t)) + 2 * (triangles / 3 + 1) * sizeof(Node);
}

} // namespace tessera

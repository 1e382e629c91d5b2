// bricking/analysis/lumen/nearest_voxels.cpp: see nearest_voxels.h.
#include "bricking/analysis/lumen/nearest_voxels.h"

#include "bricking/analysis/lumen/lumen_graph.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace tessera {
namespace {

constexpr std::uint64_t kMostBlocks = 60000;

/// A k-d tree of points: the array is ordered so that each range's middle element splits it along its axis.
class PointTree {
  public:
    explicit PointTree(std::vector<glm::dvec3> points) : points_(std::move(points)) {
        order(0, points_.size(), 0);
    }
    /// The point nearest to p, if it is nearer than best2 (squared), which gets its distance.
    void nearest(const glm::dvec3& p, double& best2, glm::dvec3& found) const {
        search(p, 0, points_.size(), 0, best2, found);
    }

  private:
    void order(std::size_t from, std::size_t to, int axis) {
        if (to - from < 2)
            return;
        const std::size_t middle = (from + to) / 2;
        const auto first = points_.begin();
        std::nth_element(first + static_cast<std::ptrdiff_t>(from),
                         first + static_cast<std::ptrdiff_t>(middle), first + static_cast<std::ptrdiff_t>(to),
                         [axis](const glm::dvec3& a, const glm::dvec3& b) { return a[axis] < b[axis]; });
        order(from, middle, (axis + 1) % 3);
        order(middle + 1, to, (axis + 1) % 3);
    }
    void search(const glm::dvec3& p, std::size_t from, std::size_t to, int axis, double& best2,
                glm::dvec3& found) const {
        if (from >= to)
            return;
        const std::size_t middle = (from + to) / 2;
        const glm::dvec3 away = points_[middle] - p;
        if (const double d2 = glm::dot(away, away); d2 < best2) {
            best2 = d2;
            found = points_[middle];
        }
        const double side = away[axis];
        const int next = (axis + 1) % 3;
        if (side > 0)
            search(p, from, middle, next, best2, found);
        else
            search(p, middle + 1, to, next, best2, found);
        if (side * side >= best2)
            return;
        if (side > 0)
            search(p, middle + 1, to, next, best2, found);
        else
            search(p, from, middle, next, best2, found);
    }
    std::vector<glm::dvec3> points_;
};

template <typename Use>
void eachVoxel(const VoxelSet& voxels, const glm::ivec3& low, const glm::ivec3& high, const Use& use) {
    glm::ivec3 v;
    for (v.z = std::max(low.z, 0); v.z < std::min(high.z, voxels.extentVoxels().z); ++v.z)
        for (v.y = std::max(low.y, 0); v.y < std::min(high.y, voxels.extentVoxels().y); ++v.y)
            for (v.x = std::max(low.x, 0); v.x < std::min(high.x, voxels.extentVoxels().x); ++v.x)
                if (voxels.contains(v))
                    use(v);
}

bool atSurface(const VoxelSet& voxels, const glm::ivec3& v) {
    return !(voxels.contains({v.x - 1, v.y, v.z}) && voxels.contains({v.x + 1, v.y, v.z}) &&
             voxels.contains({v.x, v.y - 1, v.z}) && voxels.contains({v.x, v.y + 1, v.z}) &&
             voxels.contains({v.x, v.y, v.z - 1}) && voxels.contains({v.x, v.y, v.z + 1}));
}

} // namespace

NearestVoxel nearestVoxel(const LumenShape& shape, const glm::dvec3& mm) {
    const VoxelSet& voxels = shape.voxels();
    const double halfDiagonal =
        0.5 * glm::length(shape.mmOf(glm::dvec3(kChunkExtent)) - shape.mmOf(glm::dvec3(0)));
    struct Near {
        double mm;
        std::size_t chunk;
    };
    std::vector<Near> chunks; // and the least distance of their voxels
    for (const std::size_t chunk : voxels.filledChunks()) {
        const glm::dvec3 middle =
            glm::dvec3(gridPosition(chunk, voxels.chunks()) * kChunkExtent) + 0.5 * kChunkExtent;
        // any diagonal of a sheared box may be the longest; twice the half diagonal is never less
        chunks.push_back({glm::length(shape.mmOf(middle) - mm) - 2 * halfDiagonal, chunk});
    }
    std::sort(chunks.begin(), chunks.end(),
              [](const Near& a, const Near& b) { return a.mm != b.mm ? a.mm < b.mm : a.chunk < b.chunk; });
    NearestVoxel found{{}, std::numeric_limits<double>::infinity()};
    for (const Near& near : chunks) {
        if (near.mm >= found.mm)
            break;
        const glm::ivec3 low = gridPosition(near.chunk, voxels.chunks()) * kChunkExtent;
        eachVoxel(voxels, low, low + kChunkExtent, [&](const glm::ivec3& v) {
            if (const double away = glm::length(shape.middleOf(v) - mm); away < found.mm)
                found = {v, away};
        });
    }
    return found;
}

Gap nearestGap(const LumenShape& a, const LumenShape& b, MemoryBudget& ram) {
    // first pairs of blocks that can hold the nearest voxels, then voxels at the surfaces of these blocks
    struct Side {
        const LumenShape& shape;
        LumenGraph graph;
        std::vector<glm::dvec3> middles;
        double radius; // an upper bound of the distance of a block's voxels from its centre
        Side(const LumenShape& s, MemoryBudget& budget)
            : shape(s), graph(s.voxels(), glm::dvec3(1), kMostBlocks, budget) {
            for (LumenNode node = 0; node < graph.count(); ++node)
                middles.push_back(shape.mmOf(graph.middle(node)));
            const auto n = static_cast<double>(graph.blockExtent());
            const glm::dvec3 zero = shape.mmOf(glm::dvec3(0));
            radius =
                0.5 * (glm::length(shape.mmOf({n, 0, 0}) - zero) + glm::length(shape.mmOf({0, n, 0}) - zero) +
                       glm::length(shape.mmOf({0, 0, n}) - zero));
        }
        std::vector<glm::dvec3> surfaceNear(const PointTree& others, double most) const {
            std::vector<glm::dvec3> found;
            for (LumenNode node = 0; node < graph.count(); ++node) {
                double best2 = most * most;
                glm::dvec3 other;
                others.nearest(middles[node], best2, other);
                if (best2 >= most * most)
                    continue;
                checkInterrupted();
                const glm::ivec3 low = graph.block(node) * graph.blockExtent();
                eachVoxel(shape.voxels(), low, low + graph.blockExtent(), [&](const glm::ivec3& v) {
                    if (atSurface(shape.voxels(), v))
                        found.push_back(shape.middleOf(v));
                });
            }
            return found;
        }
    };
    const Side first(a, ram), second(b, ram);
    const Charge charge = ram.charge((first.middles.size() + second.middles.size()) * 2 * sizeof(glm::dvec3),
                                     "where two parts come nearest");
    const PointTree firstTree(first.middles), secondTree(second.middles);
    double best2 = std::numeric_limits<double>::infinity();
    glm::dvec3 other;
    for (const glm::dvec3& middle : first.middles)
        secondTree.nearest(middle, best2, other);
    const double most = std::sqrt(best2) + 2 * (first.radius + second.radius) + 1e-6;
    const std::vector<glm::dvec3> from = first.surfaceNear(secondTree, most);
    const PointTree to(second.surfaceNear(firstTree, most));
    Gap gap;
    best2 = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& p : from) {
        const double before = best2;
        to.nearest(p, best2, gap.toMm);
        if (best2 < before)
            gap.fromMm = p;
    }
    gap.mm = std::sqrt(best2);
    return gap;
}

} // namespace tessera

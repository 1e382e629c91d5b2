// render/parts/part_tree.h: the parts of a volume that several processes draw: boxes of bricks, split
// along bricks' borders as a k-d tree, their order from an eye, and the segments of a ray that each of them
// has.
#pragma once

#include "bricking/levels/selection.h"
#include "render/contract/ray.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

/// Segments of a ray, from first to before end.
struct SegmentRange {
    std::int32_t first = 0, end = INT32_MAX;
    bool operator==(const SegmentRange&) const = default;
};

/// How far along their lattices rays may be cut: strides start at multiples of so many segments, of which
/// each is so many voxels long.
struct CutUnit {
    int segments = 1; // the longest stride
    double segmentVoxels = 1;
};

class PartTree {
  public:
    /// Bricks from low to before high; equal: the part has none.
    struct Box {
        glm::ivec3 low{0}, high{0};
    };

    /// Splits the grid of bricks into `count` parts that have about as many samples each. Parts that are left
    /// over where bricks are too few have none.
    PartTree(const Selection& selection, int count);

    int count() const { return static_cast<int>(boxes_.size()); }
    const Box& box(int part) const { return boxes_.at(static_cast<std::size_t>(part)); }
    /// All parts, those before others first: on no ray of the frame anything of a later one lies before.
    std::vector<int> order(const RayFrame<double>& frame) const;
    /// A ray's segments in a part. Those of all parts, in order(), are one behind another, and together all
    /// of the ray. A segment lies at most half of the unit's length from its part.
    /// @param entry  where the ray enters the drawn part of the volume, along its line, voxels
    SegmentRange segments(int part, const RayFrame<double>& frame, const RayLine<double>& line, double entry,
                          const CutUnit& unit) const;
    /// Bricks with samples in a part's box and the layer of bricks around it.
    std::vector<std::size_t> bricksAround(int part, const Selection& selection) const;

  private:
    /// A plane between bricks, at the lower border of brick `at`; or a part.
    struct Node {
        int axis = 0, at = 0;
        int lower = -1, upper = -1; // nodes; -1: a part
        int part = -1;
    };
    /// A plane that bounds a part.
    struct Side {
        int axis = 0;
        double at = 0;      // voxels
        bool upper = false; // the part lies above it
    };
    int split(const Selection& selection, const Box& box, int first, int count, std::vector<Side>& path);
    void addInOrder(int node, const RayFrame<double>& frame, std::vector<int>& order) const;

    std::vector<Node> nodes_;
    std::vector<Box> boxes_;
    std::vector<std::vector<Side>> sides_; // of every part
};

/// Bricks per level.
std::array<std::size_t, kLevelCount + 1> countsOf(std::span<const std::size_t> bricks,
                                                  const Selection& selection);

} // namespace tessera

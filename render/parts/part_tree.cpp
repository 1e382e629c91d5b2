// render/parts/part_tree.cpp: see part_tree.h.
#include "render/parts/part_tree.h"

#include "core/base/brick.h"
#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace tessera {
namespace {

/// Samples of a brick of a level; those without any of their own count for nothing.
std::uint64_t samplesOf(std::uint8_t level) {
    return level + 1 < kLevelCount ? std::uint64_t{1} << (3 * (kLevelCount - 1 - level)) : 0;
}

template <typename Visit> void forEachBrick(const PartTree::Box& box, const Visit& visit) {
    for (int k = box.low.z; k < box.high.z; ++k)
        for (int j = box.low.y; j < box.high.y; ++j)
            for (int i = box.low.x; i < box.high.x; ++i)
                visit(glm::ivec3(i, j, k));
}

/// What lies below a plane is met before what lies above it.
bool isLowerFirst(const RayFrame<double>& frame, int axis, double at) {
    if (!frame.perspective)
        return frame.toCentre[axis] >= 0;
    return frame.centre[axis] - frame.toCentre[axis] < at; // the eye
}

} // namespace

PartTree::PartTree(const Selection& selection, int count)
    : boxes_(static_cast<std::size_t>(count)), sides_(static_cast<std::size_t>(count)) {
    TESSERA_CHECK(count > 0);
    std::vector<Side> path;
    split(selection, {glm::ivec3(0), selection.bricks}, 0, count, path);
}

/// Returns the node. Parts have numbers from `first` on.
int PartTree::split(const Selection& selection, const Box& box, int first, int count,
                    std::vector<Side>& path) {
    const int number = static_cast<int>(nodes_.size());
    nodes_.emplace_back();
    glm::ivec3 low = box.high, high = box.low; // of what has samples
    std::array<std::vector<std::uint64_t>, 3> layers;
    for (int axis = 0; axis < 3; ++axis)
        layers[static_cast<std::size_t>(axis)].assign(
            static_cast<std::size_t>(box.high[axis] - box.low[axis]), 0);
    std::uint64_t all = 0;
    if (count > 1)
        forEachBrick(box, [&](const glm::ivec3& at) {
            const std::uint64_t samples = samplesOf(selection.levels[linearIndex(at, selection.bricks)]);
            if (samples == 0)
                return;
            all += samples;
            low = glm::min(low, at);
            high = glm::max(high, at + 1);
            for (int axis = 0; axis < 3; ++axis)
                layers[static_cast<std::size_t>(axis)][static_cast<std::size_t>(at[axis] - box.low[axis])] +=
                    samples;
        });
    int longest = 0;
    for (int axis = 1; axis < 3; ++axis)
        if (high[axis] - low[axis] > high[longest] - low[longest])
            longest = axis;
    if (count == 1 || all == 0 || high[longest] - low[longest] < 2) {
        nodes_[static_cast<std::size_t>(number)].part = first;
        boxes_[static_cast<std::size_t>(first)] = box;
        sides_[static_cast<std::size_t>(first)] = path;
        return number;
    }
    // Where the samples below are nearest to the share of the parts there.
    const int below = count / 2;
    const double wanted = static_cast<double>(all) * below / count;
    double sum = 0, nearest = -1;
    int at = low[longest] + 1;
    for (int layer = low[longest]; layer + 1 < high[longest]; ++layer) {
        sum += static_cast<double>(
            layers[static_cast<std::size_t>(longest)][static_cast<std::size_t>(layer - box.low[longest])]);
        if (nearest < 0 || std::abs(sum - wanted) < nearest) {
            nearest = std::abs(sum - wanted);
            at = layer + 1;
        }
    }
    Box lower = box, upper = box;
    lower.high[longest] = upper.low[longest] = at;
    path.push_back({longest, static_cast<double>(at) * kBrickExtent, false});
    const int lowerNode = split(selection, lower, first, below, path);
    path.back().upper = true;
    const int upperNode = split(selection, upper, first + below, count - below, path);
    path.pop_back();
    nodes_[static_cast<std::size_t>(number)] = {longest, at, lowerNode, upperNode, -1};
    return number;
}

void PartTree::addInOrder(int node, const RayFrame<double>& frame, std::vector<int>& order) const {
    const Node& here = nodes_[static_cast<std::size_t>(node)];
    if (here.part >= 0) {
        order.push_back(here.part);
        return;
    }
    const bool lowerFirst = isLowerFirst(frame, here.axis, static_cast<double>(here.at) * kBrickExtent);
    addInOrder(lowerFirst ? here.lower : here.upper, frame, order);
    addInOrder(lowerFirst ? here.upper : here.lower, frame, order);
}

std::vector<int> PartTree::order(const RayFrame<double>& frame) const {
    std::vector<int> order;
    addInOrder(0, frame, order);
    for (int part = 0; part < count(); ++part) // those without bricks
        if (std::find(order.begin(), order.end(), part) == order.end())
            order.push_back(part);
    return order;
}

SegmentRange PartTree::segments(int part, const RayFrame<double>& frame, const RayLine<double>& line,
                                double entry, const CutUnit& unit) const {
    constexpr double kMostSegments = 1 << 24; // of a ray
    const Box& box = this->box(part);
    if (box.low == box.high)
        return {0, 0};
    SegmentRange range;
    for (const Side& side : sides_[static_cast<std::size_t>(part)]) {
        const bool lowerFirst = isLowerFirst(frame, side.axis, side.at);
        const double base = line.base[side.axis], along = line.direction[side.axis];
        std::int32_t behind = INT32_MAX; // the first segment behind the plane; at first: all are before it
        if (lowerFirst ? along > 0 : along < 0) {
            const double units =
                std::round(((side.at - base) / along - entry) / (unit.segmentVoxels * unit.segments));
            behind = static_cast<std::int32_t>(std::clamp(units * unit.segments, 0.0, kMostSegments));
        } else if (!frame.perspective && along == 0 && lowerFirst == (base >= side.at)) {
            behind = 0;
        }
        if (side.upper == lowerFirst)
            range.first = std::max(range.first, behind);
        else
            range.end = std::min(range.end, behind);
    }
    return range.first < range.end ? range : SegmentRange{0, 0};
}

std::vector<std::size_t> PartTree::bricksAround(int part, const Selection& selection) const {
    std::vector<std::size_t> bricks;
    const Box& box = this->box(part);
    if (box.low != box.high)
        forEachBrick({glm::max(box.low - 1, glm::ivec3(0)), glm::min(box.high + 1, selection.bricks)},
                     [&](const glm::ivec3& at) {
                         const std::size_t brick = linearIndex(at, selection.bricks);
                         if (samplesOf(selection.levels[brick]) > 0)
                             bricks.push_back(brick);
                     });
    return bricks;
}

std::array<std::size_t, kLevelCount + 1> countsOf(std::span<const std::size_t> bricks,
                                                  const Selection& selection) {
    std::array<std::size_t, kLevelCount + 1> counts{};
    for (const std::size_t brick : bricks)
        ++counts[selection.levels[brick]];
    return counts;
}

} // namespace tessera

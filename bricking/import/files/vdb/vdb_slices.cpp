// bricking/import/files/vdb/vdb_slices.cpp: see vdb_slices.h.
#include "bricking/import/files/vdb/vdb_slices.h"

#include "bricking/import/files/vdb/vdb_bytes.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kMostHeldBytes = std::size_t{256} << 20;

std::size_t cubed(int side) {
    const auto n = static_cast<std::size_t>(side);
    return n * n * n;
}

/// The multiple of a side at or below a coordinate.
int alignedDown(int at, int side) {
    return at & ~(side - 1); // a power of two
}

} // namespace

VdbSlices::VdbSlices(InputFile file, VdbGrid grid, VdbHead head, VdbTree tree, const VdbBox& box)
    : file_(std::move(file)), grid_(std::move(grid)), head_(std::move(head)), tree_(std::move(tree)),
      box_(box), values_(head_.compression, grid_.isHalf, tree_.background) {}

std::span<const float> VdbSlices::slice(int z) {
    const glm::ivec3 extent = box_.extent();
    const std::size_t plane = static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y);
    const int at = box_.low.z + z;
    if (at < first_ || at >= end_) {
        const bool isLayer = plane * kVdbLeaf * sizeof(float) <= kMostHeldBytes;
        const int layer = alignedDown(at, kVdbLeaf);
        if (isLayer)
            fill(std::max(layer, box_.low.z), std::min(layer + kVdbLeaf - 1, box_.high.z) + 1);
        else
            fill(at, at + 1);
    }
    return std::span(held_).subspan(static_cast<std::size_t>(at - first_) * plane, plane);
}

void VdbSlices::fill(int first, int end) {
    checkInterrupted();
    if (!isFound_) {
        findVdbLeaves(file_, grid_, head_, tree_);
        std::ranges::sort(tree_.leaves, [](const VdbNode& a, const VdbNode& b) {
            return std::pair(a.origin.z, a.at) < std::pair(b.origin.z, b.at);
        });
        isFound_ = true;
    }
    const glm::ivec3 extent = box_.extent();
    first_ = end_ = 0; // what was here goes
    held_.assign(static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y) *
                     static_cast<std::size_t>(end - first),
                 tree_.background);
    first_ = first, end_ = end;
    try {
        for (const VdbTile& tile : tree_.tiles)
            putCube(tile.origin, kVdbUpper, tile.value);
        // Children cover the whole of their places.
        for (const VdbNode& node : tree_.uppers)
            putTiles(node, kVdbUpper / kVdbLower, kVdbLower);
        for (const VdbNode& node : tree_.lowers)
            putTiles(node, kVdbLower / kVdbLeaf, kVdbLeaf);
        const auto isBelow = [](const VdbNode& leaf, int z) { return leaf.origin.z < z; };
        const int layer = alignedDown(first, kVdbLeaf);
        for (auto leaf = std::lower_bound(tree_.leaves.begin(), tree_.leaves.end(), layer, isBelow);
             leaf != tree_.leaves.end() && leaf->origin.z == layer; ++leaf)
            putLeaf(*leaf);
    } catch (...) {
        first_ = end_ = 0;
        throw;
    }
}

float* VdbSlices::rowAt(int y, int z) {
    const glm::ivec3 extent = box_.extent();
    return held_.data() + (static_cast<std::size_t>(z - first_) * static_cast<std::size_t>(extent.y) +
                           static_cast<std::size_t>(y - box_.low.y)) *
                              static_cast<std::size_t>(extent.x);
}

void VdbSlices::putCube(const glm::ivec3& origin, int side, float value) {
    const int x0 = std::max(origin.x, box_.low.x), x1 = std::min(origin.x + (side - 1), box_.high.x),
              y0 = std::max(origin.y, box_.low.y), y1 = std::min(origin.y + (side - 1), box_.high.y),
              z0 = std::max(origin.z, first_), z1 = std::min(origin.z + (side - 1), end_ - 1);
    for (int z = z0; z <= z1; ++z)
        for (int y = y0; y <= y1 && x0 <= x1; ++y)
            std::fill_n(rowAt(y, z) + (x0 - box_.low.x), x1 - x0 + 1, value);
}

void VdbSlices::putTiles(const VdbNode& node, int across, int side) {
    const int whole = across * side;
    for (int axis = 0; axis < 3; ++axis) {
        const int low = axis == 2 ? first_ : box_.low[axis], high = axis == 2 ? end_ - 1 : box_.high[axis];
        if (node.origin[axis] > high || node.origin[axis] + (whole - 1) < low)
            return;
    }
    VdbBytes bytes(file_, node.at, grid_.leavesAt);
    const std::size_t count = cubed(across);
    children_.resize(count / 8), active_.resize(count / 8), node_.resize(count);
    bytes.read(children_);
    bytes.read(active_);
    values_.read(bytes, active_, node_);
    const int z = (first_ - node.origin.z) / side; // slices that are held lie within one row of tiles
    const auto background = std::bit_cast<std::uint32_t>(tree_.background);
    for (int x = 0; x < across; ++x)
        for (int y = 0; y < across; ++y) {
            const auto n = static_cast<std::size_t>((x * across + y) * across + z);
            if (!isOn(children_, n) && std::bit_cast<std::uint32_t>(node_[n]) != background)
                putCube(node.origin + side * glm::ivec3(x, y, z), side, node_[n]);
        }
}

void VdbSlices::putLeaf(const VdbNode& leaf) {
    for (int axis = 0; axis < 2; ++axis)
        if (leaf.origin[axis] > box_.high[axis] || leaf.origin[axis] + (kVdbLeaf - 1) < box_.low[axis])
            return;
    constexpr std::size_t kPortion = 2560; // masks, and values that are not packed
    VdbBytes bytes(file_, leaf.at, grid_.end, kPortion);
    const std::size_t count = cubed(kVdbLeaf);
    active_.resize(count / 8), node_.resize(count);
    bytes.read(active_);
    values_.read(bytes, active_, node_);
    const int x0 = std::max(leaf.origin.x, box_.low.x),
              x1 = std::min(leaf.origin.x + kVdbLeaf - 1, box_.high.x),
              y0 = std::max(leaf.origin.y, box_.low.y),
              y1 = std::min(leaf.origin.y + kVdbLeaf - 1, box_.high.y);
    for (int z = first_; z < end_; ++z)
        for (int y = y0; y <= y1; ++y) {
            float* const row = rowAt(y, z);
            for (int x = x0; x <= x1; ++x) {
                const glm::ivec3 in = glm::ivec3(x, y, z) - leaf.origin; // z goes up first
                row[x - box_.low.x] =
                    node_[static_cast<std::size_t>((in.x * kVdbLeaf + in.y) * kVdbLeaf + in.z)];
            }
        }
}

} // namespace tessera

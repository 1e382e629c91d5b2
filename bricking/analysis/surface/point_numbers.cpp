// bricking/analysis/surface/point_numbers.cpp: see point_numbers.h.
#include "bricking/analysis/surface/point_numbers.h"

#include <algorithm>

namespace tessera {
namespace {

std::size_t product(int a, int b) {
    return static_cast<std::size_t>(a) * static_cast<std::size_t>(b);
}

} // namespace

std::size_t PointNumbers::bytes(const glm::ivec3& planes, const glm::ivec3& block) {
    return sizeof(std::uint32_t) *
           (3 * product(block.x, block.y) * static_cast<std::size_t>(block.z) +
            2 * product(block.z, block.y) + 2 * product(block.z, planes.x) + 2 * product(planes.y, planes.x));
}

PointNumbers::PointNumbers(const glm::ivec3& planes, const glm::ivec3& block, MemoryBudget& ram)
    : planes_(planes), block_(block),
      charge_(ram.charge(bytes(planes, block), "numbers of a surface's points")),
      numbers_(3 * product(block.x, block.y) * static_cast<std::size_t>(block.z), kNone) {
    shared_[0].resize(2 * product(block.z, block.y), kNone);
    shared_[1].resize(2 * product(block.z, planes.x), kNone);
    shared_[2].resize(2 * product(planes.y, planes.x), kNone);
}

template <typename Visit> void PointNumbers::eachShared(int axis, int plane, const Visit& visit) {
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2; // u fastest
    // Along x, and for faces between layers along y too, all places of the lattice are kept; else the
    // block's.
    const int wide = axis == 0 ? block_.y : planes_.x;
    const int uFirst = axis == 0 ? 0 : low_.x, vFirst = axis == 2 ? low_.y : 0;
    glm::ivec3 local(0);
    local[axis] = plane - low_[axis];
    for (local[v] = 0; local[v] <= high_[v] - low_[v]; ++local[v])
        for (local[u] = 0; local[u] <= high_[u] - low_[u]; ++local[u]) {
            const std::size_t at =
                2 * (product(vFirst + local[v], wide) + static_cast<std::size_t>(uFirst + local[u]));
            // Edges that leave the block are another's.
            if (local[u] < high_[u] - low_[u])
                visit(shared_[axis][at], numbers_[indexOf(local, u)]);
            if (local[v] < high_[v] - low_[v])
                visit(shared_[axis][at + 1], numbers_[indexOf(local, v)]);
        }
}

void PointNumbers::begin(const glm::ivec3& low, const glm::ivec3& high) {
    low_ = low, high_ = high;
    std::fill(numbers_.begin(), numbers_.end(), kNone);
    // What blocks of this layer, and of this row, have put in the place of older numbers comes last.
    for (const int axis : {2, 1, 0})
        if (low[axis] > 0)
            eachShared(axis, low[axis], [](std::uint32_t shared, std::uint32_t& own) { own = shared; });
}

void PointNumbers::end() {
    for (int axis = 0; axis < 3; ++axis)
        eachShared(axis, high_[axis], [](std::uint32_t& shared, std::uint32_t own) { shared = own; });
}

void PointNumbers::skip(const glm::ivec3& low, const glm::ivec3& high) {
    low_ = low, high_ = high; // an edge with a point has one in every block around it: there is none here
    for (int axis = 0; axis < 3; ++axis)
        eachShared(axis, high_[axis], [](std::uint32_t& shared, std::uint32_t) { shared = kNone; });
}

} // namespace tessera

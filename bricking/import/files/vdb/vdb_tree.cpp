// bricking/import/files/vdb/vdb_tree.cpp: see vdb_tree.h. Rules: tree/RootNode.h, InternalNode.h and
// LeafNode.h of OpenVDB 10.
#include "bricking/import/files/vdb/vdb_tree.h"

#include "bricking/import/files/vdb/vdb_bytes.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <set>
#include <tuple>

namespace tessera {
namespace {

constexpr std::size_t kLeafValues = kVdbLeaf * kVdbLeaf * kVdbLeaf, kLeafMask = kLeafValues / 8;

class TreeReader {
  public:
    TreeReader(const InputFile& file, const VdbGrid& grid, const VdbHead& head)
        : bytes_(file, head.treeAt, grid.leavesAt), grid_(grid), head_(head) {
        tree_.low = glm::ivec3(std::numeric_limits<int>::max());
        tree_.high = glm::ivec3(std::numeric_limits<int>::min());
    }

    VdbTree read() {
        if (const auto buffers = bytes_.number<std::int32_t>(); buffers != 1)
            bytes_.refuse("a tree of one buffer", std::to_string(buffers));
        tree_.background = bytes_.number<float>();
        values_ = VdbValues(head_.compression, grid_.isHalf, tree_.background);
        const auto tiles = bytes_.number<std::uint32_t>(), children = bytes_.number<std::uint32_t>();
        for (std::uint32_t n = 0; n < tiles; ++n) {
            const glm::ivec3 origin = rootOrigin();
            tree_.tiles.push_back({origin, bytes_.number<float>()});
            if (bytes_.number<std::uint8_t>() != 0)
                addTile(origin, kVdbUpper);
        }
        for (std::uint32_t n = 0; n < children; ++n)
            readUpper(rootOrigin());
        if (bytes_.left() != 0)
            bytes_.refuse("leaves behind the tree's nodes", std::to_string(bytes_.left()) + " bytes more");
        compareWithHead();
        return std::move(tree_);
    }

  private:
    /// A mask that is damaged makes another tree, which nothing else tells of.
    void compareWithHead() const {
        const bool isEmpty = tree_.high.x < tree_.low.x;
        const auto require = [&](bool isSame, const char* name) {
            if (!isSame)
                bytes_.refuse(std::string(name) + " of the grid's metadata as in its tree",
                              "another (damage)");
        };
        require(!head_.voxels || static_cast<double>(*head_.voxels) == tree_.activeVoxels,
                "file_voxel_count");
        require(isEmpty || !head_.low || *head_.low == tree_.low, "file_bbox_min");
        require(isEmpty || !head_.high || *head_.high == tree_.high, "file_bbox_max");
    }

    glm::ivec3 rootOrigin() {
        glm::ivec3 origin;
        for (int axis = 0; axis < 3; ++axis)
            origin[axis] = bytes_.number<std::int32_t>();
        if (origin != origin / kVdbUpper * kVdbUpper || !seen_.insert({origin.x, origin.y, origin.z}).second)
            bytes_.refuse("nodes below the root at different multiples of 4096, up to 2^30",
                          std::to_string(origin.x) + ", " + std::to_string(origin.y) + ", " +
                              std::to_string(origin.z));
        return origin;
    }

    void addActive(const glm::ivec3& low, const glm::ivec3& high) {
        tree_.low = glm::min(tree_.low, low);
        tree_.high = glm::max(tree_.high, high);
    }
    void addTile(const glm::ivec3& origin, int side) {
        addActive(origin, origin + (side - 1));
        const double voxels = static_cast<double>(side) * side * side;
        tree_.heldVoxels += voxels;
        tree_.activeVoxels += voxels;
    }

    /// A node of `across`^3 children of some side; f(origin) reads each.
    template <typename Child>
    void readNode(const glm::ivec3& origin, int across, int side, std::vector<VdbNode>& nodes,
                  const Child& child) {
        checkInterrupted();
        nodes.push_back({origin, bytes_.at()});
        const auto count = static_cast<std::size_t>(across) * static_cast<std::size_t>(across) *
                           static_cast<std::size_t>(across);
        std::vector<std::byte> children(count / 8), active(count / 8);
        bytes_.read(children);
        bytes_.read(active);
        values_.skip(bytes_, active);
        const auto place = [&](std::size_t n) {
            const int at = static_cast<int>(n); // z goes up first
            return origin + side * glm::ivec3(at / (across * across), at / across % across, at % across);
        };
        for (std::size_t n = 0; n < count; ++n) {
            if (isOn(children, n))
                child(place(n));
            else if (isOn(active, n))
                addTile(place(n), side);
        }
    }

    void readUpper(const glm::ivec3& origin) {
        readNode(origin, kVdbUpper / kVdbLower, kVdbLower, tree_.uppers, [&](const glm::ivec3& lower) {
            readNode(lower, kVdbLower / kVdbLeaf, kVdbLeaf, tree_.lowers,
                     [&](const glm::ivec3& leaf) { readLeaf(leaf); });
        });
    }

    void readLeaf(const glm::ivec3& origin) {
        std::array<std::uint64_t, kVdbLeaf> planes; // of x; bits: y * 8 + z
        bytes_.read(std::as_writable_bytes(std::span(planes)));
        tree_.leaves.push_back({origin, 0});
        tree_.heldVoxels += kLeafValues;
        std::uint64_t all = 0;
        unsigned x = 0;
        for (std::size_t n = 0; n < planes.size(); ++n) {
            all |= planes[n];
            tree_.activeVoxels += std::popcount(planes[n]);
            x |= planes[n] != 0 ? 1u << n : 0u;
        }
        if (all == 0)
            return;
        unsigned y = 0, z = 0;
        for (unsigned n = 0; n < kVdbLeaf; ++n) {
            const auto row = static_cast<unsigned>(all >> (8 * n) & 255);
            z |= row;
            y |= row != 0 ? 1u << n : 0u;
        }
        const auto first = [](unsigned bits) { return std::countr_zero(bits); };
        const auto last = [](unsigned bits) { return std::bit_width(bits) - 1; };
        addActive(origin + glm::ivec3(first(x), first(y), first(z)),
                  origin + glm::ivec3(last(x), last(y), last(z)));
    }

    VdbBytes bytes_;
    const VdbGrid& grid_;
    const VdbHead& head_;
    VdbTree tree_;
    VdbValues values_{0, false, 0};
    std::set<std::tuple<int, int, int>> seen_;
};

} // namespace

VdbTree readVdbTree(const InputFile& file, const VdbGrid& grid, const VdbHead& head) {
    return TreeReader(file, grid, head).read();
}

void findVdbLeaves(const InputFile& file, const VdbGrid& grid, const VdbHead& head, VdbTree& tree) {
    VdbBytes bytes(file, grid.leavesAt, grid.end);
    VdbValues values(head.compression, grid.isHalf, tree.background);
    std::size_t done = 0;
    for (VdbNode& leaf : tree.leaves) {
        constexpr std::size_t kEvery = 4096;
        if (done++ % kEvery == 0)
            checkInterrupted();
        leaf.at = bytes.at();
        std::array<std::byte, kLeafMask> active;
        bytes.read(active);
        values.skip(bytes, active);
    }
    if (bytes.left() != 0)
        bytes.refuse("leaves up to the end of the grid", std::to_string(bytes.left()) + " bytes more");
}

} // namespace tessera

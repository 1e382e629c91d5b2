// bricking/analysis/lumen/lumen_graph.h: a lumen as a graph for path search. Its blocks have edges of 1, 2,
// 4, 8 or 16 voxels, depending on the lumen's size. A node is a connected part of the lumen within a block
// (over faces of voxels), so a wall through a block separates nodes. Two nodes are neighbours if their voxels
// touch. At any block size the graph connects exactly what level 0 connects.
#pragma once

#include "bricking/analysis/lumen/voxel_set.h"

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

namespace tessera {

using LumenNode = std::uint32_t;
constexpr LumenNode kNoNode = std::numeric_limits<LumenNode>::max();

struct LumenStep {
    LumenNode to;
    float mm; ///< between the blocks' middles
};

class LumenGraph {
  public:
    /// The smallest blocks of which the set occupies at most mostBlocks, or blocks of 16. The set must
    /// outlive the graph.
    /// @param spacingMm  of voxels
    /// Throws InputError naming the budget's option if it does not fit.
    LumenGraph(const VoxelSet& voxels, const glm::dvec3& spacingMm, std::uint64_t mostBlocks,
               MemoryBudget& ram);

    int blockExtent() const { return extent_; }
    LumenNode count() const { return static_cast<LumenNode>(blocks_.size()); }
    /// kNoNode if the voxel is not in the set.
    LumenNode nodeAt(const glm::ivec3& voxel) const;
    /// Position in the grid of blocks.
    const glm::ivec3& block(LumenNode node) const { return blocks_[node]; }
    /// A voxel of the node.
    glm::ivec3 someVoxel(LumenNode node) const;
    /// Middle of the block, voxel space.
    glm::dvec3 middle(LumenNode node) const { return (glm::dvec3(blocks_[node]) + 0.5) * double(extent_); }
    /// The same in mm along the voxels' axes, without shear.
    glm::dvec3 middleMm(LumenNode node) const { return middle(node) * spacing_; }
    const glm::dvec3& spacingMm() const { return spacing_; }
    /// Calls use with every node of a block, which may lie outside the grid.
    template <typename Use> void eachNode(const glm::ivec3& block, const Use& use) const {
        const LumenNode node = first(block);
        if (node == kNoNode)
            return;
        use(node);
        if (const auto more = more_.find(node); more != more_.end())
            for (const LumenNode other : more->second)
                use(other);
    }
    /// Distance to the outside of the lumen, mm. It is exact between the centres of blocks that are at least
    /// half filled and of those that are not. For the latter it is up to a quarter of a block, by their
    /// filling. A shear of the volume's axes is ignored.
    float wallMm(LumenNode node) const { return wall_[node]; }
    float widestMm() const { return widest_; }

    /// Writes a node's neighbours to `steps`: over faces, and diagonally where all blocks between are full.
    void neighbours(LumenNode node, std::vector<LumenStep>& steps) const;

    /// A chain of face-connected voxels of the set, through the nodes of a path.
    /// @param path  nodes that are neighbours, one at least; from and to lie in its first and last
    std::vector<glm::ivec3> voxelChain(std::span<const LumenNode> path, const glm::ivec3& from,
                                       const glm::ivec3& to) const;

  private:
    using Rows = std::vector<std::uint32_t>; // of a block: row y + n z, bit x
    static constexpr int kTile = 8;
    using Tile = std::array<LumenNode, kTile * kTile * kTile>;

    void build();
    void addBlock(const glm::ivec3& block, Rows&& rows, std::uint32_t filled);
    void joinFaces();
    void measure();
    LumenNode first(const glm::ivec3& block) const;
    LumenNode& slot(const glm::ivec3& block);
    Rows rowsOf(const glm::ivec3& block) const;
    Rows rowsOf(LumenNode node) const;
    bool full(LumenNode node) const { return flags_[node] & kFull; }
    bool parted(LumenNode node) const { return flags_[node] & kParted; }
    /// True if voxels touch across face `axis` from a to the block at its upper side.
    bool touch(const Rows& a, const Rows& b, int axis) const;
    bool solid(const glm::ivec3& block) const;
    void chainWithin(std::vector<glm::ivec3>& chain, LumenNode node, LumenNode next,
                     const glm::ivec3& to) const;

    static constexpr std::uint8_t kFull = 64,
                                  kParted = 128; // below: faces with touching voxels, -x +x -y +y -z +z
    const VoxelSet& voxels_;
    glm::dvec3 spacing_;
    int extent_ = 1;
    Charge charge_;
    glm::ivec3 tilesLow_{0}, tiles_{0};
    std::vector<std::uint32_t> tileOf_;
    std::vector<Tile> tileNodes_;
    std::vector<glm::ivec3> blocks_;
    std::vector<std::uint16_t> filled_; // voxels of the block, at most 65535
    std::vector<std::uint8_t> flags_;
    std::vector<float> wall_;
    float widest_ = 0;
    std::unordered_map<LumenNode, Rows> parts_; // voxels of nodes of blocks with several nodes
    std::unordered_map<LumenNode, std::vector<LumenNode>>
        more_; // by the first node of such a block: the others
};

} // namespace tessera

// bricking/import/files/vdb/vdb_slices.h: a box of an OpenVDB tree as dense slices. Private to the reader.
#pragma once

#include "bricking/import/files/vdb/vdb_tree.h"
#include "bricking/import/source/source_files.h"

#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

/// Of voxels, both ends included.
struct VdbBox {
    glm::ivec3 low{0}, high{0};
    glm::ivec3 extent() const { return high - low + 1; }
};

class VdbSlices {
  public:
    VdbSlices(InputFile file, VdbGrid grid, VdbHead head, VdbTree tree, const VdbBox& box);

    /// [y][x], valid until the next call: every voxel's value, active or not. Memory holds the slices of a
    /// layer of leaves, up to 256 MiB of them, or one. Throws InputError naming the file for damage.
    /// @param z  from 0 on
    std::span<const float> slice(int z);

  private:
    void fill(int first, int end);
    void putCube(const glm::ivec3& origin, int side, float value);
    void putTiles(const VdbNode& node, int across, int side);
    void putLeaf(const VdbNode& leaf);
    float* rowAt(int y, int z);

    InputFile file_;
    VdbGrid grid_;
    VdbHead head_;
    VdbTree tree_;
    VdbBox box_;
    VdbValues values_;
    bool isFound_ = false;    // where the leaves are
    int first_ = 0, end_ = 0; // of the slices that are held, as indices of the tree
    std::vector<float> held_, node_;
    std::vector<std::byte> children_, active_;
};

} // namespace tessera

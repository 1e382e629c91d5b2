// bricking/import/files/vdb/vdb_tree.h: a tree of floats of OpenVDB: where its nodes are in space and in the
// file, and which box its active voxels have. Private to the reader.
#pragma once

#include "bricking/import/files/vdb/vdb_file.h"
#include "bricking/import/files/vdb/vdb_values.h"
#include "bricking/import/source/source_files.h"

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Three levels below the root: 32^3 nodes of 16^3 leaves of 8^3 voxels.
constexpr int kVdbLeaf = 8, kVdbLower = 16 * kVdbLeaf, kVdbUpper = 32 * kVdbLower;

struct VdbNode {
    glm::ivec3 origin{0};
    std::uint64_t at = 0; // of its masks and values
};
/// A cube of one value below the root.
struct VdbTile {
    glm::ivec3 origin{0};
    float value = 0;
};

struct VdbTree {
    float background = 0;
    std::vector<VdbTile> tiles; // of side kVdbUpper
    std::vector<VdbNode> uppers,
        lowers;                  // of sides kVdbUpper, kVdbLower; their tiles are of kVdbLower, kVdbLeaf
    std::vector<VdbNode> leaves; // places in the file: by findVdbLeaves()
    glm::ivec3 low{0}, high{-1}; // of active voxels; none: high is below low
    double heldVoxels = 0;       // in leaves and active tiles
    double activeVoxels = 0;
};

/// Reads the topology, in one pass over the part of the file before the leaves; memory holds 24 bytes a leaf.
/// Throws InputError naming the file for damage.
VdbTree readVdbTree(const InputFile& file, const VdbGrid& grid, const VdbHead& head);

/// Finds the leaves' values, in one pass over the rest. Throws InputError naming the file for damage, and
/// where they do not end with the grid.
void findVdbLeaves(const InputFile& file, const VdbGrid& grid, const VdbHead& head, VdbTree& tree);

} // namespace tessera

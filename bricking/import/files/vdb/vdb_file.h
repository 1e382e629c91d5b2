// bricking/import/files/vdb/vdb_file.h: the grids of an OpenVDB file, and what a grid says before its tree.
// Private to the reader.
#pragma once

#include "bricking/import/source/source_files.h"

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// An entry of the file's list.
struct VdbGrid {
    std::string name;    // "density", "density[1]"
    std::string type;    // "Tree_float_5_4_3"
    bool isHalf = false; // floats are halves in the file
    std::string treeOf;  // the grid that has its tree; "": itself
    std::uint64_t at = 0, leavesAt = 0, end = 0;
    bool isFloat() const { return type == "Tree_float_5_4_3"; }
};

/// Throws InputError naming the file for one that is no OpenVDB file of versions 222 to 224 (since 2013), and
/// for grids beyond its end.
std::vector<VdbGrid> readVdbGrids(const InputFile& file);

/// Of a grid, before its tree.
struct VdbHead {
    std::uint32_t compression = 0; // kVdbZip and others
    std::string gridClass;         // "fog volume", "level set"
    std::string unit, space;       // as `tessera export` writes them; "": not said
    std::optional<glm::ivec3> extent;
    /// Of active voxels, as the library counted them.
    std::optional<glm::ivec3> low, high;
    std::optional<std::int64_t> voxels;
    /// The place of index (0,0,0), and steps along i, j, k.
    glm::dvec3 origin{0};
    std::array<glm::dvec3, 3> step = {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)};
    std::uint64_t treeAt = 0;
};

/// What `tessera export` says of patient space: LPS, mm.
inline constexpr std::string_view kVdbSpace = "left-posterior-superior, mm";

/// Throws InputError naming the file for damage, and for a transform that is not linear.
VdbHead readVdbHead(const InputFile& file, const VdbGrid& grid);

} // namespace tessera

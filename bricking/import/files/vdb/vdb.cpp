// bricking/import/files/vdb/vdb.cpp: grids of floats and halves in OpenVDB files, as slices of the box of
// their active voxels. The tree is walked over and read here, not by the library: that holds a grid as a
// whole, and copies as many bytes as a damaged file says.
#include "bricking/import/files/file_format.h"
#include "bricking/import/files/header_words.h"
#include "bricking/import/files/vdb/vdb_slices.h"
#include "bricking/import/source/plausible.h"
#include "bricking/import/source/slice_converter.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

class VdbSource final : public RandomSlabSource {
  public:
    VdbSource(VdbSlices slices, VolumeInfo info, std::string description)
        : slices_(std::move(slices)), info_(std::move(info)), description_(std::move(description)),
          converter_(FileType::f32, false, [this](const auto& visit) {
              for (int z = 0; z < info_.extentVoxels.z; ++z)
                  visit(std::as_bytes(slices_.slice(z)));
          }) {}

    const VolumeInfo& info() const override { return info_; }
    std::string describe() const override { return description_; }
    VoxelTally takeTally() override { return converter_.takeTally(); }
    std::size_t roomBytes() const override { return 2 * sliceBytesOf(info_); }

    void readSliceAt(int z, std::span<std::byte> out) override {
        TESSERA_CHECK(z >= 0 && z < info_.extentVoxels.z && out.size() == sliceBytesOf(info_));
        const std::span<const float> slice = slices_.slice(z);
        slice_.assign(slice.begin(), slice.end()); // another pass may read others meanwhile
        converter_.convert(std::as_bytes(std::span(slice_)), out, info_);
    }

  private:
    VdbSlices slices_;
    VolumeInfo info_;
    std::string description_;
    SliceConverter converter_;
    std::vector<float> slice_;
};

/// The only grid of floats, or the one that is chosen.
/// @param chosen  from 1 on, of the grids of floats; 0: none is
const VdbGrid& gridOf(const std::vector<VdbGrid>& grids, std::size_t chosen, const std::string& where) {
    std::vector<const VdbGrid*> floats;
    std::string others;
    for (const VdbGrid& grid : grids)
        if (grid.isFloat())
            floats.push_back(&grid);
        else
            others += (others.empty() ? "" : ", ") + shownWord(grid.name) + " (" + shownWord(grid.type) + ")";
    if (floats.empty())
        throw badFile(where, "a grid of floats or halves (Tree_float_5_4_3)",
                      others.empty() ? "no grid" : others);
    if (chosen == 0 && floats.size() > 1)
        throw badFile(where, "one grid of floats, or the name of the file and --series N",
                      std::to_string(floats.size()) + " of them");
    if (chosen > floats.size())
        throw badFile(where, "--series between 1 and " + std::to_string(floats.size()),
                      std::to_string(chosen));
    const VdbGrid& grid = *floats[std::max<std::size_t>(chosen, 1) - 1];
    if (!grid.treeOf.empty())
        throw badFile(where, "a grid with a tree of its own", "one with that of " + shownWord(grid.treeOf));
    return grid;
}

/// Of voxels: that of its active ones, or the one that `tessera export` says.
VdbBox boxOf(const VdbTree& tree, const VdbHead& head, const std::string& where) {
    const bool isEmpty = tree.high.x < tree.low.x;
    const auto text = [](const glm::dvec3& v) {
        const auto whole = [](double n) { return std::to_string(static_cast<std::int64_t>(n)); };
        return whole(v.x) + "x" + whole(v.y) + "x" + whole(v.z);
    };
    VdbBox box{tree.low, tree.high};
    if (head.extent) {
        const glm::ivec3 extent = *head.extent;
        for (int axis = 0; axis < 3; ++axis)
            if (extent[axis] < 1 || (!isEmpty && (tree.low[axis] < 0 || tree.high[axis] >= extent[axis])))
                throw badFile(where,
                              "active voxels within the grid's tessera_extent " + text(glm::dvec3(extent)),
                              "others");
        box = {glm::ivec3(0), extent - 1};
    } else if (isEmpty) {
        throw badFile(where, "a grid with active voxels", "none");
    }
    const glm::dvec3 extent = glm::dvec3(box.high) - glm::dvec3(box.low) + 1.0;
    // Nothing else bounds a place that is wrong.
    constexpr double kMostSparse = 16384, kLeastHeld = 16384, kMostOfSlice = double{1 << 29};
    const double voxels = extent.x * extent.y * extent.z;
    if (voxels > kMostSparse * std::max(tree.heldVoxels, kLeastHeld) || extent.x * extent.y > kMostOfSlice ||
        extent.z > std::numeric_limits<int>::max())
        throw badFile(where,
                      "a box that the tree fills to a 16384th at least, with slices of 2^29 voxels at most",
                      text(extent) + " voxels for " + numberText(tree.heldVoxels) + " of the tree");
    return box;
}

std::vector<FileVolume> volumesOfVdb(const std::filesystem::path& path) {
    std::vector<FileVolume> volumes;
    for (const VdbGrid& grid : readVdbGrids(InputFile(path)))
        if (grid.isFloat())
            volumes.push_back({shownWord(grid.name), {static_cast<int>(volumes.size()) + 1}});
    return volumes.size() > 1 ? volumes : std::vector<FileVolume>{};
}

std::unique_ptr<SlabSource> openVdb(const std::filesystem::path& path, const SourceOptions& options) {
    InputFile file(path);
    const std::string where = path.string();
    const std::vector<VdbGrid> grids = readVdbGrids(file);
    const VdbGrid grid = gridOf(grids, static_cast<std::size_t>(options.series), where);
    const VdbHead head = readVdbHead(file, grid);
    VdbTree tree = readVdbTree(file, grid, head);
    const VdbBox box = boxOf(tree, head, where);
    VolumeInfo info;
    info.extentVoxels = box.extent();
    info.type = ValueType::f32;
    info.fillStored = std::isfinite(tree.background) ? tree.background : 0;
    glm::dvec3 first = head.origin;
    for (int axis = 0; axis < 3; ++axis)
        first += static_cast<double>(box.low[axis]) * head.step[static_cast<std::size_t>(axis)];
    info.patientFromVoxel = patientFromVoxelOf(first, head.step[0], head.step[1], head.step[2]);
    requirePlausibleGeometry(info, {"the transform", "the transform", "the transform"}, where);
    info.orientationKnown = head.space == kVdbSpace;
    if (head.unit == "HU" || head.unit == kSuvUnit) // as `tessera export` writes it
        info.unit = head.unit;
    if (head.space.empty())
        info.remarks.emplace_back(
            "OpenVDB files do not say which way their axes point, and in which unit; taken as LPS, mm");
    if (const auto others =
            std::count_if(grids.begin(), grids.end(), [](const VdbGrid& each) { return !each.isFloat(); }))
        info.remarks.push_back("other grids of the file, which are no volumes, are left out: " +
                               std::to_string(others));
    info.validate(where);
    std::string description = std::string("OpenVDB ") + (grid.isHalf ? "float16" : "float32");
    if (head.gridClass == "level set")
        description +=
            ", a level set: distances from its surface, negative inside, within its narrow band of " +
            numberText(std::abs(tree.background)) + " to either side";
    return std::make_unique<VdbSource>(VdbSlices(std::move(file), grid, head, std::move(tree), box),
                                       std::move(info), std::move(description));
}

} // namespace

FileFormat vdbFormat() {
    return {.inFolders = "OpenVDB grids", .named = ".vdb", .open = openVdb, .volumes = volumesOfVdb};
}

} // namespace tessera

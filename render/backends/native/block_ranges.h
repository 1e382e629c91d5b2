// render/backends/native/block_ranges.h: the range of the field in every block of 2^3 voxels of a cell,
// whatever levels meet there. Where one level has all weight, the field is plain trilinear interpolation of
// it, and a block's range is exact. Elsewhere the field is a mean, with weights that are not negative, of the
// bricks around a corner. Each of these is trilinear between its own samples and clamped to them
// (render/contract/level_map.h). So the range lies in the hull of those that have weight in the block.
#pragma once

#include "render/backends/native/host_plane.h"
#include "render/contract/level_map.h"

namespace tessera {

class BlockRanges {
  public:
    /// @param map  of mixed levels, or null
    /// @param level  else: of all bricks
    /// @param scale, offset  from values as they are stored to those of the ranges
    BlockRanges(const HostPlane& plane, const LevelMap* map, int level, float scale, float offset,
                const native::PacketTarget& target)
        : plane_(plane), map_(map), level_(level), scale_(scale), offset_(offset), target_(target) {}

    /// Of a cell, by its place among those of the volume. All bricks are there.
    const native::CellRanges& of(const glm::ivec3& cell);

  private:
    const native::PacketBrick& brickAt(const glm::ivec3& brick) const;
    void rangesOfBrick(const glm::ivec3& brick, const glm::ivec3& firstVoxel, native::CellRanges& out);
    void rangesOfLevel(int level, const glm::ivec3& firstVoxel, native::CellRanges& out);
    void rangesOfSamples(int level, const glm::ivec3& firstVoxel, native::CellRanges& out);
    void fill(const native::CellRows& part, float value);
    void addNeighbours(const glm::ivec3& cell, const BrickCorner& corner);

    const HostPlane& plane_;
    const LevelMap* map_;
    int level_;
    float scale_, offset_;
    const native::PacketTarget& target_;
    native::CellSamples samples_; // in and around a cell, of the level at hand
    native::CellRanges ranges_, others_;
};

} // namespace tessera

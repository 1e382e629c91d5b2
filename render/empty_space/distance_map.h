// render/empty_space/distance_map.h: the distance map: texels of 64 bits, each over a box of 8^3 voxels or,
// for volumes that are too large for that, over a brick. A texel of an empty box has the extent of the
// emptiness, for each of the eight octants that a ray can go into. This is a partitioned Chebyshev distance:
// what lies behind a ray does not hold it up. A texel of an occupied box says which of its 4^3 blocks can
// show anything.
//
// Empty: bit 63 is 0. Byte o holds the distance for octant o (bit 0: x ascends, 1: y, 2: z), 1 to 127. A cube
// of so many boxes an edge, from this one into the octant, is empty. Beyond the volume everything is.
// Occupied: bit 63 is 1; bit x + 4y + 16z, x fastest, is the block's; blocks 62 and 63 share bit 62.
// Chebyshev distance maps: Sramek and Kaufman 2000; partitioned by octant: Deakin and Knackstedt 2020.
#pragma once

#include "core/base/brick.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

using SkippingTexel = std::uint64_t;
constexpr SkippingTexel kOccupiedTexel = SkippingTexel{1} << 63;
constexpr int kFarthest = 127; // boxes

/// What a texel stands for: a cell of 8^3 voxels, blocks of 2^3; or a brick of 32^3 voxels, blocks of a cell.
enum class MapScale { cells, bricks };
constexpr int boxShift(MapScale scale) { // log2 of the box's edge in voxels; a block's is 2 less
    return scale == MapScale::cells ? 3 : 5;
}
glm::ivec3 mapGrid(const glm::ivec3& extentVoxels, MapScale scale);
inline std::size_t mapBytes(const glm::ivec3& extentVoxels, MapScale scale) {
    return sizeof(SkippingTexel) * cellCount(mapGrid(extentVoxels, scale));
}

/// An occupied box's texel from a bit per block.
constexpr SkippingTexel occupiedTexel(std::uint64_t blocks) {
    const std::uint64_t shared = (blocks >> 62 | blocks >> 63) & 1u;
    return kOccupiedTexel | shared << 62 | (blocks & ((std::uint64_t{1} << 62) - 1));
}
inline bool isOccupied(SkippingTexel texel) {
    return (texel & kOccupiedTexel) != 0;
}
inline int blockBit(const glm::ivec3& block) { // of block coordinates 0 to 3
    const int bit = block.x + 4 * block.y + 16 * block.z;
    return bit < 62 ? bit : 62;
}
inline int octantDistance(SkippingTexel empty, int octant) {
    return static_cast<int>((empty >> (8 * octant)) & 127u);
}

/// Slices of a map along z that hold a change: from first up to end, which is not one of them.
struct ChangedSlices {
    int first = 0, end = 0;
    bool any() const { return end > first; }
    void add(const ChangedSlices& other) {
        if (!other.any())
            return;
        first = any() ? std::min(first, other.first) : other.first;
        end = std::max(end, other.end);
    }
};

/// Fills the whole map. Exact: every distance is the largest that its octant allows, up to kFarthest.
/// @param masks  per brick, [z][y][x]: bit x + 4y + 16z of a cell that can show something; none of a cell
///     beyond the volume
/// @param map  mapGrid() texels, [z][y][x]
/// @param threads  0: all processors; more than two do not help
void fillDistanceMap(const glm::ivec3& extentVoxels, std::span<const std::uint64_t> masks, MapScale scale,
                     std::span<SkippingTexel> map, int threads);

/// Makes the map of earlier masks that of others; the same, bit for bit, as filling it anew.
/// @param changedBricks  in any order: all whose masks are others, and perhaps more
/// Returns where texels changed, or may have.
ChangedSlices updateDistanceMap(const glm::ivec3& extentVoxels, std::span<const std::uint64_t> masks,
                                MapScale scale, std::span<const std::size_t> changedBricks,
                                std::span<SkippingTexel> map, int threads);

} // namespace tessera

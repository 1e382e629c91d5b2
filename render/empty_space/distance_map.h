// render/empty_space/distance_map.h: the distance map: texels of 64 bits, each for a box of 8^3 voxels or, in
// very large volumes, for a brick. A texel of an empty box has the empty distance for each of the eight
// octants of ray directions. This is a partitioned Chebyshev distance: objects behind a ray do not shorten
// its leaps. A texel of an occupied box marks which of its 4^3 blocks can be visible.
//
// Empty: bit 63 is 0. Byte o holds the distance for octant o (bit 0: x ascends, 1: y, 2: z), 1 to 127. The
// cube with an edge of that many boxes, from this one into the octant, is empty. So is everything beyond the
// volume. Occupied: bit 63 is 1; bit x + 4y + 16z, x fastest, is the block's; blocks 62 and 63 share bit 62.
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

/// The box of a texel: a cell of 8^3 voxels with blocks of 2^3, or a brick of 32^3 voxels with blocks of a
/// cell.
enum class MapScale { cells, bricks };
constexpr int boxShift(MapScale scale) { // log2 of the box's edge in voxels; a block's is 2 less
    return scale == MapScale::cells ? 3 : 5;
}
glm::ivec3 mapGrid(const glm::ivec3& extentVoxels, MapScale scale);
inline std::size_t mapBytes(const glm::ivec3& extentVoxels, MapScale scale) {
    return sizeof(SkippingTexel) * cellCount(mapGrid(extentVoxels, scale));
}

/// The texel of an occupied box, from a bit per block.
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

/// Slices of a map along z with changes: [first, end).
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

/// Computes the whole map. Exact: every distance is the largest possible in its octant, up to kFarthest.
/// @param masks  per brick, [z][y][x]: bit x + 4y + 16z for an occupied cell; 0 for a cell beyond the volume
/// @param map  mapGrid() texels, [z][y][x]
/// @param threads  0: all processors; more than two do not help
void fillDistanceMap(const glm::ivec3& extentVoxels, std::span<const std::uint64_t> masks, MapScale scale,
                     std::span<SkippingTexel> map, int threads);

/// Updates the map for new masks; the result equals a new computation bit for bit.
/// @param changedBricks  in any order: at least all bricks with changed masks
/// Returns where texels may have changed.
ChangedSlices updateDistanceMap(const glm::ivec3& extentVoxels, std::span<const std::uint64_t> masks,
                                MapScale scale, std::span<const std::size_t> changedBricks,
                                std::span<SkippingTexel> map, int threads);

} // namespace tessera

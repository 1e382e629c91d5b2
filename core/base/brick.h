// core/base/brick.h: addresses of bricks, chunks and slots. One type per address space distinguishes a
// brick's position in the volume, a chunk's position in a level's array, and a slot in the atlas. All levels
// of a volume share these rules. A 2x2x2 average pyramid is the flat multiresolution: brick b at level l is a
// sub-box of the array of level l.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <initializer_list>

namespace tessera {

constexpr int kBrickExtent =
    32;                        // level-0 voxels; 64 KiB of int16: small enough to cull, large enough to load
constexpr int kLevelCount = 6; // 32 >> 5 = 1: at the coarsest level a brick is one sample
constexpr int kCellExtent = 8; // level-0 voxels; the unit of empty-space skipping
constexpr int kCellsPerBrick = kBrickExtent / kCellExtent;
constexpr int kChunkExtent = 32; // samples of one stored chunk, at every level

/// Position in the volume. Bricks have constant extent, so one grid position serves every level.
struct BrickId {
    int i = 0, j = 0, k = 0;
    friend constexpr auto operator<=>(const BrickId&, const BrickId&) = default;
};

/// Position in the store: chunk (i,j,k) of the array of one level (0 finest).
struct ChunkKey {
    int level = 0;
    int i = 0, j = 0, k = 0;
    friend constexpr auto operator<=>(const ChunkKey&, const ChunkKey&) = default;
};

struct ChunkKeyHash {
    std::size_t operator()(const ChunkKey& key) const {
        std::uint64_t h = static_cast<std::uint64_t>(key.level);
        for (const int part : {key.i, key.j, key.k})
            h = (h ^ static_cast<std::uint64_t>(static_cast<std::uint32_t>(part))) * 0x9E3779B97F4A7C15u;
        return static_cast<std::size_t>(h ^ (h >> 29));
    }
};

inline glm::ivec3 ceilDiv(const glm::ivec3& n, int d) {
    return (n + (d - 1)) / d;
}

/// Samples of the array of a level: ceil halves of level 0, computed level by level.
inline glm::ivec3 levelExtent(glm::ivec3 extentVoxels, int level) {
    for (int l = 0; l < level; ++l)
        extentVoxels = ceilDiv(extentVoxels, 2);
    return extentVoxels;
}
inline glm::ivec3 brickGrid(const glm::ivec3& extentVoxels) {
    return ceilDiv(extentVoxels, kBrickExtent);
}
inline glm::ivec3 cellGrid(const glm::ivec3& extentVoxels) {
    return ceilDiv(extentVoxels, kCellExtent);
}
inline glm::ivec3 chunkGrid(const glm::ivec3& extentVoxels, int level) {
    return ceilDiv(levelExtent(extentVoxels, level), kChunkExtent);
}
/// Position in an array of extent grid, x fastest; 64-bit, because float and int run out first.
inline std::size_t linearIndex(const glm::ivec3& at, const glm::ivec3& grid) {
    return (static_cast<std::size_t>(at.z) * static_cast<std::size_t>(grid.y) +
            static_cast<std::size_t>(at.y)) *
               static_cast<std::size_t>(grid.x) +
           static_cast<std::size_t>(at.x);
}
/// The inverse of linearIndex().
inline glm::ivec3 gridPosition(std::size_t index, const glm::ivec3& grid) {
    const auto x = static_cast<std::size_t>(grid.x), y = static_cast<std::size_t>(grid.y);
    return {static_cast<int>(index % x), static_cast<int>(index / x % y), static_cast<int>(index / x / y)};
}
inline std::size_t cellCount(const glm::ivec3& grid) {
    return static_cast<std::size_t>(grid.x) * static_cast<std::size_t>(grid.y) *
           static_cast<std::size_t>(grid.z);
}

} // namespace tessera

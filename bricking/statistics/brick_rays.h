// bricking/statistics/brick_rays.h: sampled rays of every brick, at every level, from which the picture of a
// brick is predicted (level_error.h). The picture depends on the values of a brick and on their order along
// rays. A ray has both; a histogram has only values.
//
// A brick's 24 rays run along the axes, each a row of voxels. 22 of them represent all such rays equally.
// Every second row in each direction is a candidate. The candidates of all three axes are sorted by their
// mean value into eleven equal groups, and each group by its distance from level 3 into two halves. The
// middle ray of each half is taken. The last two rays go through the brick's largest and smallest voxel and
// have little weight, so that small rare structures are not missed. Each of two parts has twelve rays, one of
// each group and one extreme, so one part is still a fair sample in half the memory.
//
// Along a ray, levels 0 and 1 are sampled at 16 voxels, level 2 at 8 points, level 3 at 4, levels 4 and 5 at
// 2. That is the density of samples of levels 1 to 4. Fields of levels above 0 are trilinear and use the
// neighbouring bricks' samples of the same level. A sample is 8 bits of the range of all samples of its part.
// For equal bytes, more samples per ray give better predictions than more rays.
#pragma once

#include "bricking/mask/masked_source.h"
#include "bricking/store/store_reader.h"
#include "core/base/brick.h"
#include "core/base/budget.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

constexpr int kBrickRayParts = 2;
constexpr int kRaysPerPart = 12;
constexpr int kRayGroups = kRaysPerPart - 1; // the last ray of a part is an extreme
constexpr float kExtremeWeight = 1.0f / 16;  // of a part's last ray; the others share the rest equally
/// Samples along a ray per level; each stands for an equal part of the row.
constexpr std::array<int, kLevelCount> kRaySamples = {16, 16, 8, 4, 2, 2};
constexpr int kSamplesPerRay = 48;

/// One part of a brick as it is stored, little-endian.
struct BrickRayPart {
    float lo = 0, hi = 0;   // stored units: what codes 0 and 255 stand for
    std::uint32_t axes = 0; // two bits per ray: the axis it runs along
    std::array<std::uint8_t, std::size_t{kRaysPerPart * kSamplesPerRay}> codes{}; // [ray][level][sample]
    int axis(int ray) const { return static_cast<int>(axes >> (2 * ray) & 3u); }
};
constexpr std::size_t kBrickRayBytes =
    2 * sizeof(float) + sizeof(std::uint32_t) + kRaysPerPart * kSamplesPerRay;

void encode(const BrickRayPart& part, std::span<std::uint8_t, kBrickRayBytes> bytes);
BrickRayPart decodeRays(std::span<const std::uint8_t, kBrickRayBytes> bytes);
/// hi - lo of a part.
float rangeOfRays(std::span<const std::uint8_t, kBrickRayBytes> bytes);

/// Position of sample j of a level along a row of n voxels, in voxels from the row's start. It is a voxel's
/// centre if the level has as many samples as level 0, else the middle of its part.
double raySampleAt(int j, int samples, int n);

/// The fields of one brick, for sampling: values of level 0 inside it, and the samples of each coarser level
/// in and around it.
struct BrickFields {
    glm::ivec3 size{0}; // voxels of level 0, at most 32 each
    /// [z][y][x] of size, stored units.
    std::span<const float> voxels;
    /// Whole numbers of 16 bits: their sums along rows are exact in any order. Only makes choosing quicker.
    bool isWhole = false;
    /// Samples of levels 1 .. 5 from (first) on, [z][y][x] of extent: the brick's own and one layer around it
    /// where there is one.
    struct Box {
        glm::ivec3 first{0}; // of the brick's first sample; -1 if there is a layer before it
        glm::ivec3 extent{0};
        std::span<const float> samples;
    };
    std::array<Box, kLevelCount> levels; // levels[0] is not used

    /// Trilinear; p in voxels from the brick's corner; beyond the outermost sample it is constant.
    float at(int level, const glm::dvec3& p) const;
};

/// Chooses and samples the rays of a brick. Depends on nothing but the fields.
std::array<BrickRayPart, kBrickRayParts> sampleRays(const BrickFields& fields);

/// Rays of the requested bricks, in pages, so that more can be added without moving any.
struct BrickRays {
    static constexpr std::uint32_t kNoRow = UINT32_MAX;
    static constexpr std::size_t kRowsPerPage = 256; // 294 KiB
    glm::ivec3 bricks{0};
    int parts = kBrickRayParts;                   // of kBrickRayParts
    std::vector<std::uint32_t> rowOf;             // [z][y][x]: a brick's row, or kNoRow
    std::vector<std::vector<std::uint8_t>> pages; // [row / kRowsPerPage][row % kRowsPerPage][part][bytes]
    std::size_t rows = 0;
    std::vector<Charge> charges;

    std::size_t rowBytes() const { return static_cast<std::size_t>(parts) * kBrickRayBytes; }
    /// One part of a row.
    /// @param row  below rows
    std::span<const std::uint8_t, kBrickRayBytes> part(std::uint32_t row, int part) const;
    std::span<std::uint8_t> row(std::uint32_t row);
};

// The sampled rays of bricks, read from a store's statistics for visible bricks. They take 1176 bytes per
// brick, half of that with one part.

/// Initially of no brick.
/// @param parts  1 or kBrickRayParts; one takes half the memory, for a less accurate prediction
/// Throws InputError when ram cannot hold four bytes a brick.
BrickRays noBrickRays(const VolumeInfo& info, int parts, MemoryBudget& ram);

/// Adds the missing bricks with wanted[brick] != 0; present ones do not move. Missing or damaged statistics,
/// or those of another version, are no error: rays are then sampled from the voxels, which takes as long as
/// at import.
/// @param wanted  [z][y][x] over bricks
/// @param masked  what is drawn in place of the store, or null: bricks that are hidden in part have their
/// rays
///     sampled from it, where ram has room for that
/// Throws InputError when ram cannot hold them, or when voxels cannot be read.
void addBrickRays(const StoreReader& store, std::span<const std::uint8_t> wanted, BrickRays& rays,
                  MemoryBudget& ram, int threads = 0, const MaskedSource* masked = nullptr);

} // namespace tessera

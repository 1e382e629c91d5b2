// render/empty_space/extinction_bounds.h: the least and the greatest extinction that a point of a cell can
// have, under a transfer function and at the bricks' levels: majorants and minorants of free paths
// (docs/sampling.md, "Paths").
#pragma once

#include "core/base/budget.h"
#include "render/contract/optics.h"
#include "render/empty_space/brick_proof.h"
#include "render/empty_space/distance_map.h" // MapScale

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

/// Per mm.
struct ExtinctionRange {
    float least = 0, most = 0;
    friend bool operator==(const ExtinctionRange&, const ExtinctionRange&) = default;
};

/// The range of a function's table between any two places in it.
class TableExtremes {
  public:
    explicit TableExtremes(const std::vector<glm::vec4>& table);
    /// @param from, to  in entries, ascending; places beyond the table count as its ends
    ExtinctionRange between(double from, double to) const;
    static std::size_t bytes(std::size_t entries);

  private:
    static constexpr std::size_t kBlock = 64; // entries
    ExtinctionRange over(std::size_t first, std::size_t last) const;
    float at(double place) const;

    std::vector<float> entries_;
    /// Row k: ranges of 2^k blocks from each block on.
    std::vector<std::vector<ExtinctionRange>> rows_;
};

/// Extinctions above this many a voxel count as that: thicker walls look the same, and paths would crawl.
constexpr double kMostExtinctionPerVoxel = 256;
float mostExtinctionPerMm(const VolumeInfo& info);

/// A range per cell of 8^3 voxels; of very large volumes per brick.
class ExtinctionBounds {
  public:
    ExtinctionBounds() = default;
    /// @param optics  of the same function and volume; its gradient opacity and labels count
    /// @param scale  that of the distance map
    /// @param limit  per mm: greater extinctions count as that
    /// @param threads  0: all processors
    ExtinctionBounds(const OccupancyInput& input, const Optics& optics, MapScale scale, float limit,
                     MemoryBudget& ram, int threads = 0);

    bool exists() const { return !ranges_.empty(); }
    float limit() const { return limit_; }
    /// log2 of a box's edge, voxels.
    int shift() const { return shift_; }
    const glm::ivec3& grid() const { return grid_; } // of boxes
    const glm::ivec3& extentVoxels() const { return extentVoxels_; }
    ExtinctionRange of(const glm::ivec3& box) const { return unpacked(ranges_[linearIndex(box, grid_)]); }

    static std::size_t bytes(const glm::ivec3& extentVoxels, MapScale scale, std::size_t entries);

    /// Two numbers of 16 bits, the upper halves of floats: the least is rounded down, the most up.
    static std::uint32_t packed(const ExtinctionRange& range);
    static ExtinctionRange unpacked(std::uint32_t bits) {
        return {std::bit_cast<float>(bits << 16), std::bit_cast<float>(bits & 0xffff0000u)};
    }

  private:
    int shift_ = 0;
    float limit_ = 0;
    glm::ivec3 grid_{0}, extentVoxels_{0};
    std::vector<std::uint32_t> ranges_; // [z][y][x]
    Charge charge_;
};

} // namespace tessera

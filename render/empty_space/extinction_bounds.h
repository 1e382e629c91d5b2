// render/empty_space/extinction_bounds.h: the least and the greatest extinction that a point of a cell can
// have, under a transfer function and at the bricks' levels: majorants and minorants of free paths
// (docs/sampling.md, "Paths").
#pragma once

#include "bricking/cache/brick_cache.h"
#include "core/base/budget.h"
#include "render/contract/optics.h"
#include "render/empty_space/brick_proof.h"

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

/// A range per cell of 8^3 voxels.
class ExtinctionBounds {
  public:
    ExtinctionBounds() = default;
    /// @param optics  of the same function and volume; its gradient opacity and labels count
    /// @param limit  per mm: greater extinctions count as that
    /// @param threads  0: all processors
    ExtinctionBounds(const OccupancyInput& input, const Optics& optics, float limit, MemoryBudget& ram,
                     int threads = 0);

    bool exists() const { return !ranges_.empty(); }
    float limit() const { return limit_; }
    const glm::ivec3& grid() const { return grid_; } // of cells
    const glm::ivec3& extentVoxels() const { return extentVoxels_; }
    ExtinctionRange ofCell(const glm::ivec3& cell) const {
        return unpacked(ranges_[linearIndex(cell, grid_)]);
    }
    /// The smallest box around a voxel that has a range of its own.
    struct Box {
        ExtinctionRange range;
        int shift = 0; // log2 of its edge, voxels
    };
    Box at(const glm::ivec3& voxel) const {
        const std::size_t box = linearIndex(voxel >> kCellShift, grid_);
        if (const std::int32_t part = parts_.empty() ? -1 : parts_[box]; part >= 0) {
            const glm::ivec3 in = (voxel >> kPartShift) & (kParts - 1);
            return {unpacked(partRanges_[static_cast<std::size_t>(part) * kPartsOfCell +
                                         linearIndex(in, glm::ivec3(kParts))]),
                    kPartShift};
        }
        return {unpacked(ranges_[box]), kCellShift};
    }
    /// Finds ranges of parts, 4^3 voxels, of the cells in which extinctions differ and which are plain
    /// interpolation of level 0; not in volumes beyond hasParts().
    void refine(const OccupancyInput& input, const Optics& optics, BrickCache& cache, MemoryBudget& ram,
                int threads = 0);

    // As lanes read them: [z][y][x]; parts and their ranges are empty where no cell has any.
    const std::vector<std::uint32_t>& ranges() const { return ranges_; }
    const std::vector<std::int32_t>& parts() const { return parts_; }
    const std::vector<std::uint32_t>& partRanges() const { return partRanges_; }
    std::size_t usedBytes() const { return charge_.bytes() + partsCharge_.bytes(); }
    /// RAM of all, with all parts that there may be.
    static std::size_t bytes(const glm::ivec3& extentVoxels, std::size_t entries);
    /// Of all parts that so many cells may have, and of what finds them.
    static constexpr std::size_t bytesOfParts(std::size_t cells) {
        return cells * (sizeof(std::int32_t) + (1 + kPartsOfCell) * sizeof(std::uint32_t));
    }
    /// By a volume's extent alone, so that pictures do not depend on budgets.
    static bool hasParts(const glm::ivec3& extentVoxels) {
        return cellCount(cellGrid(extentVoxels)) <= kMostWithParts;
    }

    /// Two numbers of 16 bits, the upper halves of floats: the least is rounded down, the most up.
    static std::uint32_t packed(const ExtinctionRange& range);
    static ExtinctionRange unpacked(std::uint32_t bits) {
        return {std::bit_cast<float>(bits << 16), std::bit_cast<float>(bits & 0xffff0000u)};
    }

  private:
    float limit_ = 0;
    glm::ivec3 grid_{0}, extentVoxels_{0};
    static constexpr std::size_t kMostWithParts = std::size_t{1} << 21; // cells: of 1024^3 voxels
    static constexpr int kCellShift = 3;
    static constexpr int kPartShift = 2, kParts = kCellExtent >> kPartShift,
                         kPartsOfCell = kParts * kParts * kParts;
    ExtinctionRange rangeOf(const TableExtremes& table, const Optics& optics, const Hull& hull,
                            bool labelled) const;

    std::vector<std::uint32_t> ranges_;     // [z][y][x]
    std::vector<std::int32_t> parts_;       // per cell: number of its parts, below 0: none
    std::vector<std::uint32_t> partRanges_; // [cell][z][y][x]
    Charge partsCharge_;
    Charge charge_;
};

} // namespace tessera

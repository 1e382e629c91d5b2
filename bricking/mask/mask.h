// bricking/mask/mask.h: Mask: which part of a volume pictures hide, such as the table under a patient. It is
// a small lattice of shares at one level, held whole in RAM (docs/sampling.md, "Masks").
#pragma once

#include "core/base/brick.h"
#include "core/base/budget.h"

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

class Mask {
  public:
    /// @param level   whose samples the shares are
    /// @param shares  [z][y][x] over levelExtent(extentVoxels, level): 0 shown ... 255 hidden
    /// Throws InputError if ram cannot hold bytes().
    Mask(const glm::ivec3& extentVoxels, int level, std::vector<std::uint8_t> shares, MemoryBudget& ram);
    /// Memory of such a mask: a byte for each sample of the level and of the coarser ones.
    static std::size_t bytes(const glm::ivec3& extentVoxels, int level);

    int level() const { return level_; }
    /// Shares of the mask's own level.
    std::span<const std::uint8_t> shares() const { return shares_[static_cast<std::size_t>(level_)]; }

    enum class Part : std::uint8_t { none, some, all };
    /// The part of the voxels of [low, high) that is hidden, of any sample inside too that levels up to
    /// kExactLevel have there. Some, where a voxel beside the box alone could be hidden in part.
    Part of(const glm::ivec3& low, const glm::ivec3& high) const;
    /// The hidden share of each sample of a box of a level, [0,1], [z][y][x]: trilinear between the mask's
    /// shares at finer levels than its own, at coarser ones their mean.
    /// @param count  samples of the box; within the level
    void read(int level, const glm::ivec3& first, const glm::ivec3& count, std::span<float> out) const;

    /// A sample of this level or a finer one lies within one cell, so its share cannot mix two cells.
    static constexpr int kExactLevel = 3;
    static_assert(1 << kExactLevel == kCellExtent);

  private:
    const std::vector<std::uint8_t>& sharesOf(int level) const {
        return shares_[static_cast<std::size_t>(level)];
    }

    int level_;
    std::array<glm::ivec3, kLevelCount> extents_{};
    std::array<std::vector<std::uint8_t>, kLevelCount> shares_; // of level_ and coarser ones
    Charge charge_;
};

} // namespace tessera

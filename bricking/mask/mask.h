// bricking/mask/mask.h: which part of a volume pictures hide (docs/sampling.md, "Masks"). HiddenPart is what
// a masked volume asks. Mask, such as that of the table under a patient, is a small lattice of shares at one
// level, held whole in RAM.
#pragma once

#include "core/base/brick.h"
#include "core/base/budget.h"

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace tessera {

class HiddenPart {
  public:
    virtual ~HiddenPart() = default;

    enum class Part : std::uint8_t { none, some, all };
    /// The part of the voxels of [low, high) that is hidden, of any sample inside too that levels up to
    /// kExactLevel have there. Some, where a voxel beside the box alone could be hidden in part.
    virtual Part of(const glm::ivec3& low, const glm::ivec3& high) const = 0;
    /// The hidden share of each sample of a box of a level, [0,1], [z][y][x].
    /// @param first  of a chunk
    /// @param count  samples of the box; within the level, and a chunk's at most
    /// Throws InputError naming what cannot be read.
    virtual void read(int level, const glm::ivec3& first, const glm::ivec3& count,
                      std::span<float> out) const = 0;

    /// A sample of this level or a finer one lies within one cell, so its share cannot mix two cells.
    static constexpr int kExactLevel = 3;
    static_assert(1 << kExactLevel == kCellExtent);
};

class Mask : public HiddenPart {
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

    Part of(const glm::ivec3& low, const glm::ivec3& high) const override;
    /// Trilinear between the mask's shares at finer levels than its own, at coarser ones their mean.
    void read(int level, const glm::ivec3& first, const glm::ivec3& count,
              std::span<float> out) const override;

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

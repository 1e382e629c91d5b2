// bricking/statistics/gathered_ranges.h: the ranges of a grid of boxes (cells, or bricks with layers around)
// while a pass over the bricks gathers them. All of them in memory; or where these do not fit, in a file
// without a name, and in memory those that the bricks of a band touch. Internal to this room.
#pragma once

#include "bricking/store/slab_file.h"
#include "core/base/budget.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

/// Boxes of a grid, along x all, with their ranges as [z][y][x] of extent.
struct RangeWindow {
    glm::ivec3 first{0}, extent{0};
    std::span<float> least, most;
};
/// No value yet.
void clearRanges(const RangeWindow& window);

class GatheredRanges {
  public:
    /// In memory.
    /// @param perBrick  boxes of a brick along an axis
    /// Both charge what they take to ram. Throw InputError where that does not fit.
    GatheredRanges(const glm::ivec3& grid, int perBrick, MemoryBudget& ram);
    /// In a file in the folder.
    /// @param mostBricks  of a band
    GatheredRanges(const glm::ivec3& grid, int perBrick, const glm::ivec3& mostBricks,
                   const std::filesystem::path& folder, MemoryBudget& ram);
    static std::size_t bytes(const glm::ivec3& grid);
    static std::size_t windowBytes(const glm::ivec3& grid, int perBrick, const glm::ivec3& mostBricks);

    /// The boxes that bricks of a band touch, which lie beside them too, with what was gathered before. Bands
    /// come with z ascending, of one z with y ascending, and have all bricks along x.
    void begin(const glm::ivec3& firstBrick, const glm::ivec3& endBrick);
    /// Keeps what the window has.
    void end();
    const RangeWindow& window() const { return window_; }

    enum class Side : std::uint8_t { least, most };
    /// After the last band: calls rows(values) for so many rows of a slice from a row on.
    void read(Side side, int slice, int firstRow, std::span<float> rows) const;

  private:
    std::uint64_t placeOf(Side side, int slice, int row) const;

    glm::ivec3 grid_;
    int perBrick_;
    Charge charge_;
    std::optional<SlabFile> file_;
    std::vector<float> least_, most_;
    RangeWindow window_;
    int group_ = -1;                    // z of the bricks of the last band
    int keptSlices_ = 0, keptRows_ = 0; // what the file has: whole slices, and rows of those of the group
};

} // namespace tessera

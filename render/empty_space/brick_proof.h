// render/empty_space/brick_proof.h: finds the cells of one brick that can be visible, at any levels of it and
// its neighbours. It compares the range of every sample that a point in a cell can reach with the zeros of
// the transfer function.
#pragma once

#include "bricking/levels/selection.h"
#include "bricking/statistics/statistics.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/volume.h"
#include "core/scene/scene.h"
#include "core/scene/transfer_function.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <limits>
#include <vector>

namespace tessera {

/// The inputs, which are read only during calls.
struct OccupancyInput {
    const Statistics& statistics;
    const TransferTable& table;
    const VolumeInfo& info;
    const Selection& selection;
    EdgeFunction edgeFunction = EdgeFunction::split;
};

struct Hull {
    float lo = std::numeric_limits<float>::infinity(), hi = -std::numeric_limits<float>::infinity();
    std::uint8_t shows = 0; // ShownPart: of any place in it
    void add(float low, float high) {
        lo = std::min(lo, low);
        hi = std::max(hi, high);
    }
    void add(const Hull& other) {
        add(other.lo, other.hi);
        shows |= other.shows;
    }
};

/// TransferTable::emptyOver() of stored values, inline because it is called for every cell.
class ZeroExtinction {
  public:
    ZeroExtinction(const TransferTable& table, const VolumeInfo& info)
        : nonZeroUpTo_(table.nonZeroUpTo.data()), last_(static_cast<double>(table.entries.size() - 1)) {
        const double perValue = static_cast<double>(table.entriesPerValue);
        scale_ = info.rescaleSlope * perValue;
        offset_ = (info.rescaleIntercept - static_cast<double>(table.firstValue)) * perValue;
        TESSERA_CHECK(std::isfinite(scale_) && scale_ != 0 && std::isfinite(offset_));
    }
    bool over(const Hull& h) const {
        if (h.shows != kShowsFunction) {
            if ((h.shows & kShowsMedium) != 0)
                return false;
            if (h.shows == 0)
                return true;
        }
        const double x = static_cast<double>(h.lo) * scale_ + offset_;
        const double y = static_cast<double>(h.hi) * scale_ + offset_;
        const double a = std::clamp(std::min(x, y), 0.0, last_ + 1),
                     b = std::clamp(std::max(x, y), -1.0, last_);
        const int first = std::max(static_cast<int>(a) - 1, 0); // floor - 1
        const int whole = static_cast<int>(b);
        const int final = std::min(whole + (whole < b ? 1 : 0) + 1, static_cast<int>(last_)); // ceil + 1
        return nonZeroUpTo_[final] == (first == 0 ? 0 : nonZeroUpTo_[first - 1]);
    }

  private:
    const int* nonZeroUpTo_;
    double last_, scale_ = 0, offset_ = 0;
};

/// A cell's bit in a brick's mask.
inline std::size_t cellBit(const glm::ivec3& at) {
    return static_cast<std::size_t>(at.x + 4 * at.y + 16 * at.z);
}
/// A range of cells of a brick along one axis, both ends included.
struct Span {
    int first = 0, last = 0;
};

/// Tests the cells of one brick against a function, with current levels and stored statistics.
class BrickProof {
  public:
    /// @param wide  per brick, the range over it and the bricks that touch it
    /// @param finest  level in use
    BrickProof(const OccupancyInput& input, const std::vector<glm::vec2>& wide, std::uint32_t finest);

    std::uint64_t cellsOf(const glm::ivec3& brick);
    using CellHulls = std::array<Hull, 64>; // x + 4y + 16z
    /// Ranges of the cells of a brick. Returns the number of its cells along each axis; others are not set.
    glm::ivec3 rangesOf(const glm::ivec3& brick, CellHulls& hulls);
    /// Of that brick and the neighbours that reach it: the coarsest level.
    int coarsestAround() const { return coarsest_; }
    /// Cells of a brick of level 0 that only level 0 and empty bricks reach, as with a single level.
    std::uint64_t plainCellsOf(const glm::ivec3& brick);

  private:
    struct Neighbour {
        glm::ivec3 side{0}, brick{0};
        int level = 0;
        bool plain = true;    // blends over half a sample of level 0
        glm::ivec3 layers{0}; // of cells that it reaches, per crossed axis
    };
    static bool isValue(int level) { return level + 1 >= kLevelCount; } // its value is its mean
    int levelOf(const glm::ivec3& brick) const {
        return in_.selection.levels[linearIndex(brick, in_.selection.bricks)];
    }
    Hull rangeOf(const glm::ivec3& brick, int level) const {
        const std::size_t b = linearIndex(brick, in_.selection.bricks);
        if (isValue(level))
            return {in_.selection.means[b], in_.selection.means[b], in_.statistics.showsOfBrick(b, 1)};
        return voxelRange(b);
    }
    /// Range of a brick's voxels and one layer around them.
    Hull voxelRange(std::size_t brick) const {
        return {in_.statistics.brickMin[brick], in_.statistics.brickMax[brick],
                in_.statistics.showsOfBrick(brick, 1)};
    }
    bool empty(const Hull& h) const { return zero_.over(h); }
    Hull cellRange(const glm::ivec3& cell) const {
        const std::size_t c = linearIndex(cell, in_.statistics.cells);
        return {in_.statistics.cellMin[c], in_.statistics.cellMax[c], in_.statistics.showsOfCell(c)};
    }
    Hull rangeOver(const glm::ivec3& firstCell, const Span& x, const Span& y, const Span& z) const;
    void findNeighbours(const glm::ivec3& brick, int level, bool everyOne);
    /// Ranges of cells by the brick's samples and those of the neighbours that were found.
    glm::ivec3 rangesAmong(const glm::ivec3& brick, CellHulls& hulls) const;
    /// Adds its samples to the ranges of cells whose points can reach them.
    void addNeighbour(const Neighbour& n, const glm::ivec3& firstCell, const glm::ivec3& cells,
                      CellHulls& hulls) const;

    const OccupancyInput& in_;
    const std::vector<glm::vec2>& wide_;
    struct Edge {
        int layers = 0; // of cells that the neighbour reaches
        bool plain = false;
    };
    std::array<std::array<Edge, kLevelCount + 1>, kLevelCount + 1>
        edges_; // [neighbour's level][level it faces]
    ZeroExtinction zero_;
    std::array<Neighbour, 27> neighbours_; // one to spare
    int count_ = 0, coarsest_ = 0;
};

} // namespace tessera

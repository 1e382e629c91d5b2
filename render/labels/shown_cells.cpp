// render/labels/shown_cells.cpp: the ranges of cells and bricks whose labels show: see drawn_labels.h.
#include "core/base/brick.h"
#include "core/base/error.h"
#include "render/labels/drawn_labels.h"

#include <algorithm>
#include <cstdint>
#include <glm/common.hpp>
#include <limits>

namespace tessera {
namespace {

constexpr std::uint8_t kFunction = 1, kMedium = 2; // what shows of a cell
constexpr float kInfinite = std::numeric_limits<float>::infinity(),
                kNothing = std::numeric_limits<float>::quiet_NaN();

/// Of each cell and those that touch it, along one axis after another.
void spread(std::vector<std::uint8_t>& shows, const glm::ivec3& cells) {
    for (int axis = 0; axis < 3; ++axis) {
        const std::vector<std::uint8_t> before = shows;
        const std::size_t step = axis == 0 ? 1
                                 : axis == 1
                                     ? static_cast<std::size_t>(cells.x)
                                     : static_cast<std::size_t>(cells.x) * static_cast<std::size_t>(cells.y);
        std::size_t n = 0;
        for (int z = 0; z < cells.z; ++z)
            for (int y = 0; y < cells.y; ++y)
                for (int x = 0; x < cells.x; ++x, ++n) {
                    const int at = axis == 0 ? x : axis == 1 ? y : z;
                    if (at > 0)
                        shows[n] |= before[n - step];
                    if (at + 1 < cells[axis])
                        shows[n] |= before[n + step];
                }
    }
}

struct ShownRange {
    float low = kInfinite, high = -kInfinite;
    void add(float least, float most) { // nothing adds nothing
        low = std::min(low, least);
        high = std::max(high, most);
    }
    void put(float& least, float& most) const {
        least = low > high ? kNothing : low;
        most = low > high ? kNothing : high;
    }
};

} // namespace

void DrawnLabels::showOnly(Statistics& s, MemoryBudget& ram) const {
    TESSERA_CHECK(s.cells == cells_ && s.bricks == bricks_);
    const std::size_t count = cellCount(cells_);
    const Charge charge = ram.charge(2 * count, "which cells have labels");
    std::vector<std::uint8_t> shows(count);
    for (std::size_t cell = 0; cell < count; ++cell)
        for (const LabelCells::Share& share : volume_->cells().of(cell)) {
            const LabelFactors& f = bySet_[share.set];
            shows[cell] |= (f.plain > 0 || f.tinted > 0 ? kFunction : 0) | (f.solid > 0 ? kMedium : 0);
        }
    spread(shows, cells_);
    for (std::size_t cell = 0; cell < count; ++cell) {
        if (shows[cell] & kMedium) {
            s.cellMin[cell] = -kInfinite, s.cellMax[cell] = kInfinite;
        } else if (!(shows[cell] & kFunction)) {
            s.cellMin[cell] = s.cellMax[cell] = kNothing;
        }
    }
    // A brick's range with a layer of voxels around is that of its cells; with two, by cells that touch it.
    for (std::size_t b = 0; b < s.brickMin.size(); ++b) {
        const glm::ivec3 first = gridPosition(b, bricks_) * kCellsPerBrick;
        const glm::ivec3 end = glm::min(first + kCellsPerBrick, cells_);
        const glm::ivec3 from = glm::max(first - 1, glm::ivec3(0)), to = glm::min(end + 1, cells_);
        ShownRange own, wide;
        bool isWhole = true; // all around has the function alone
        for (int z = from.z; z < to.z; ++z)
            for (int y = from.y; y < to.y; ++y)
                for (int x = from.x; x < to.x; ++x) {
                    const glm::ivec3 at(x, y, z);
                    const std::size_t cell = linearIndex(at, cells_);
                    isWhole = isWhole && shows[cell] == kFunction;
                    wide.add(s.cellMin[cell], s.cellMax[cell]);
                    if (glm::all(glm::greaterThanEqual(at, first)) && glm::all(glm::lessThan(at, end)))
                        own.add(s.cellMin[cell], s.cellMax[cell]);
                }
        if (isWhole)
            continue;
        own.put(s.brickMin[b], s.brickMax[b]);
        wide.put(s.wideMin[b], s.wideMax[b]);
    }
}

} // namespace tessera

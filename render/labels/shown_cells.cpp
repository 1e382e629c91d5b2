// render/labels/shown_cells.cpp: what shows of cells and bricks with labels: see drawn_labels.h.
#include "core/base/brick.h"
#include "core/base/error.h"
#include "render/labels/drawn_labels.h"

#include <algorithm>
#include <cstdint>
#include <glm/common.hpp>
#include <utility>

namespace tessera {
namespace {

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

} // namespace

/// True if something changes in a cell, or between it and one with which it has a face in common.
bool DrawnLabels::hasBorder(const glm::ivec3& cell) const {
    const auto sharesOf = [&](const glm::ivec3& at) { return volume_->cells().of(linearIndex(at, cells_)); };
    const auto own = sharesOf(cell);
    const LabelFactors& one = bySet_[own.front().set];
    const auto differs = [&](const LabelCells::Share& share) { return bySet_[share.set] != one; };
    if (std::any_of(own.begin(), own.end(), differs))
        return true;
    for (int side = 0; side < 6; ++side) {
        glm::ivec3 next = cell;
        next[side / 2] += side % 2 == 0 ? 1 : -1;
        if (next[side / 2] >= 0 && next[side / 2] < cells_[side / 2] && differs(sharesOf(next).front()))
            return true;
    }
    return false;
}

/// Of cells [first, end). Borders in the cells that touch them count a little, too: between a coarse brick
/// and one that has a border at its face both are blended, deep into the coarse one.
Statistics::LabelledBrick DrawnLabels::labelledBrick(const glm::ivec3& first, const glm::ivec3& end) const {
    constexpr double kBeside = 1.0 / 16;
    const glm::ivec3 from = glm::max(first - 1, glm::ivec3(0)), to = glm::min(end + 1, cells_);
    double voxels = 0, function = 0, medium = 0, borders = 0;
    for (int z = from.z; z < to.z; ++z)
        for (int y = from.y; y < to.y; ++y)
            for (int x = from.x; x < to.x; ++x) {
                const glm::ivec3 cell(x, y, z);
                const bool isOwn =
                    glm::all(glm::greaterThanEqual(cell, first)) && glm::all(glm::lessThan(cell, end));
                if (hasBorder(cell))
                    borders += isOwn ? 1 : kBeside;
                if (!isOwn)
                    continue;
                for (const LabelCells::Share& share : volume_->cells().of(linearIndex(cell, cells_))) {
                    const LabelFactors& f = bySet_[share.set];
                    voxels += share.voxels;
                    function += static_cast<double>(f.plain + f.tinted) * share.voxels;
                    medium += f.solid > 0 ? share.voxels : 0;
                }
            }
    if (!(voxels > 0))
        return {};
    const double cells = static_cast<double>(cellCount(end - first));
    return {static_cast<float>(function / voxels), static_cast<float>(medium / voxels),
            static_cast<float>(std::min(1.0, borders / cells))};
}

void DrawnLabels::showOnly(Statistics& s, MemoryBudget& ram) {
    TESSERA_CHECK(s.cells == cells_ && s.bricks == bricks_);
    const std::size_t cells = cellCount(cells_), bricks = cellCount(bricks_);
    showsCharge_ =
        ram.charge(cells + bricks * (2 + sizeof(Statistics::LabelledBrick)), "what shows of labels");
    const Charge spreading = ram.charge(cells, "which cells have labels");
    std::vector<std::uint8_t> shows(cells);
    for (std::size_t cell = 0; cell < cells; ++cell)
        for (const LabelCells::Share& share : volume_->cells().of(cell)) {
            const LabelFactors& f = bySet_[share.set];
            shows[cell] |=
                (f.plain > 0 || f.tinted > 0 ? kShowsFunction : 0) | (f.solid > 0 ? kShowsMedium : 0);
        }
    spread(shows, cells_);
    s.brickShows.assign(bricks, 0);
    s.wideShows.assign(bricks, 0);
    // With one layer a brick's own cells say enough, with two those that touch it.
    for (std::size_t b = 0; b < bricks; ++b) {
        const glm::ivec3 first = gridPosition(b, bricks_) * kCellsPerBrick;
        const glm::ivec3 end = glm::min(first + kCellsPerBrick, cells_);
        const glm::ivec3 from = glm::max(first - 1, glm::ivec3(0)), to = glm::min(end + 1, cells_);
        for (int z = from.z; z < to.z; ++z)
            for (int y = from.y; y < to.y; ++y)
                for (int x = from.x; x < to.x; ++x) {
                    const glm::ivec3 at(x, y, z);
                    const std::uint8_t part = shows[linearIndex(at, cells_)];
                    s.wideShows[b] |= part;
                    if (glm::all(glm::greaterThanEqual(at, first)) && glm::all(glm::lessThan(at, end)))
                        s.brickShows[b] |= part;
                }
    }
    s.cellShows = std::move(shows);
    s.labelledBricks.resize(bricks);
    for (std::size_t b = 0; b < bricks; ++b) {
        const glm::ivec3 first = gridPosition(b, bricks_) * kCellsPerBrick;
        s.labelledBricks[b] = labelledBrick(first, glm::min(first + kCellsPerBrick, cells_));
    }
}

} // namespace tessera

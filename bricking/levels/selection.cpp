// bricking/levels/selection.cpp: see selection.h.
#include "bricking/levels/selection.h"

#include "core/base/budget_error.h"
#include "core/base/error.h"

#include <algorithm>

namespace tessera {

int Selection::finest() const {
    for (int level = 0; level < kLevelCount; ++level)
        if (counts[static_cast<std::size_t>(level)] > 0)
            return level;
    return kLevelCount - 1;
}

int Selection::coarsest() const {
    for (int level = kLevelCount - 1; level >= 0; --level)
        if (counts[static_cast<std::size_t>(level)] > 0)
            return level;
    return kLevelCount - 1;
}

namespace {

/// The ranges of a brick's cells, and of one around them.
void addCellsAround(const Statistics& statistics, const glm::ivec3& brick, float& lo, float& hi,
                    std::uint8_t& shows) {
    const glm::ivec3 first = glm::max(brick * kCellsPerBrick - 1, glm::ivec3(0)),
                     last = glm::min((brick + 1) * kCellsPerBrick, statistics.cells - 1);
    for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x) {
                const std::size_t cell = linearIndex({x, y, z}, statistics.cells);
                lo = std::min(lo, statistics.cellMin[cell]);
                hi = std::max(hi, statistics.cellMax[cell]);
                shows |= statistics.showsOfCell(cell);
            }
}

} // namespace

Selection cullBricks(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
                     int level, Culling culling) {
    Selection s;
    s.bricks = brickGrid(info.extentVoxels);
    s.levels.assign(cellCount(s.bricks), static_cast<std::uint8_t>(level));
    s.means = statistics.brickMean;
    TESSERA_CHECK(s.means.size() == s.levels.size());
    const bool lit = culling == Culling::lit || culling == Culling::smooth;
    const int layers = lit || !table.gradientOpacity.isOne() ? 2 : 1;
    for (int k = 0; k < s.bricks.z; ++k)
        for (int j = 0; j < s.bricks.y; ++j)
            for (int i = 0; i < s.bricks.x; ++i) {
                std::uint8_t& mine = s.levels[linearIndex({i, j, k}, s.bricks)];
                float lo = 0, hi = 0;
                statistics.brickRange({i, j, k}, layers, lo, hi);
                std::uint8_t shows = statistics.showsOfBrick(linearIndex({i, j, k}, s.bricks), layers);
                if (culling == Culling::smooth)
                    addCellsAround(statistics, {i, j, k}, lo, hi, shows);
                const double a = info.rescaleSlope * static_cast<double>(lo) + info.rescaleIntercept;
                const double b = info.rescaleSlope * static_cast<double>(hi) + info.rescaleIntercept;
                const bool isEmpty = (shows & kShowsMedium) == 0 &&
                                     (shows == 0 || table.emptyOver(std::min(a, b), std::max(a, b)));
                if (culling != Culling::none && isEmpty)
                    mine = Selection::kEmpty;
                ++s.counts[mine];
            }
    return s;
}

Selection selectOneLevel(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
                         std::size_t availableBytes, const PackedBytes& packedBytes, Culling culling,
                         const std::string& budgetName, std::size_t fixedBytes, int finest) {
    Selection s = cullBricks(statistics, table, info, 0, culling);
    const std::size_t shown = s.shownBricks();
    std::size_t coarsestBytes = 0;
    for (int level = finest; level < kLevelCount; ++level) {
        std::array<std::size_t, kLevelCount + 1> counts{};
        counts[static_cast<std::size_t>(level)] = shown;
        coarsestBytes = packedBytes(counts);
        if (fixedBytes > availableBytes || coarsestBytes > availableBytes - fixedBytes)
            continue;
        counts[Selection::kEmpty] = s.counts[Selection::kEmpty];
        s.counts = counts;
        for (std::uint8_t& mine : s.levels)
            if (mine != Selection::kEmpty)
                mine = static_cast<std::uint8_t>(level);
        return s;
    }
    throw OverBudget(budgetName + ": this scene needs at least " + formatBytes(fixedBytes + coarsestBytes) +
                     " (its bricks at the coarsest level, picture and tables), but " +
                     formatBytes(availableBytes) + " are free");
}

} // namespace tessera

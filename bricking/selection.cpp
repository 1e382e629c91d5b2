// bricking/selection.cpp: see selection.h.
#include "bricking/selection.h"

#include "core/error.h"

#include <algorithm>

namespace tessera {

Selection selectOneLevel(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
                         std::size_t availableBytes, const PackedBytes& packedBytes, bool cull,
                         const std::string& budgetName, std::size_t fixedBytes) {
    Selection s;
    s.bricks = brickGrid(info.extentVoxels);
    s.states.assign(cellCount(s.bricks), BrickState::resident);
    s.means = statistics.brickMean;
    TESSERA_CHECK(s.means.size() == s.states.size());
    for (int k = 0; k < s.bricks.z; ++k)
        for (int j = 0; j < s.bricks.y; ++j)
            for (int i = 0; i < s.bricks.x; ++i) {
                float lo = 0, hi = 0;
                statistics.brickRange({i, j, k}, lo, hi);
                const double a = info.rescaleSlope * static_cast<double>(lo) + info.rescaleIntercept;
                const double b = info.rescaleSlope * static_cast<double>(hi) + info.rescaleIntercept;
                if (cull && table.emptyOver(std::min(a, b), std::max(a, b)))
                    s.states[linearIndex({i, j, k}, s.bricks)] = BrickState::empty;
                else
                    ++s.residentCount;
            }
    for (s.level = 0; s.level < kLevelCount && fixedBytes <= availableBytes; ++s.level)
        if (packedBytes(s.residentCount, s.level) <= availableBytes - fixedBytes)
            return s;
    throw InputError(budgetName + ": this scene needs at least " +
                     formatBytes(fixedBytes + packedBytes(s.residentCount, kLevelCount - 1)) +
                     " (its bricks at the coarsest level, picture and tables), but " +
                     formatBytes(availableBytes) + " are free");
}

} // namespace tessera

// bricking/statistics/coarse_statistics.cpp: see coarse_statistics.h.
#include "bricking/statistics/coarse_statistics.h"

#include "bricking/statistics/fill_values.h"
#include "bricking/statistics/statistics_layout.h"
#include "bricking/statistics/statistics_pass.h"
#include "bricking/statistics/statistics_reader.h"
#include "bricking/store/buffer_pool.h"
#include "bricking/store/remote_files.h"
#include "core/base/address.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cstddef>
#include <glm/common.hpp>
#include <limits>

namespace tessera {
namespace {

/// Calls body(cell, brick) for all cells, by their numbers.
template <typename Body>
void eachCellOfBricks(const glm::ivec3& cells, const glm::ivec3& bricks, int threads, const Body& body) {
    parallelFor(static_cast<std::size_t>(cells.z), threads, [&](std::size_t layer) {
        const int z = static_cast<int>(layer);
        for (int y = 0; y < cells.y; ++y) {
            std::size_t cell = linearIndex({0, y, z}, cells);
            const std::size_t row = linearIndex(glm::ivec3(0, y, z) / kCellsPerBrick, bricks);
            for (int x = 0; x < cells.x; ++x, ++cell)
                body(cell, row + static_cast<std::size_t>(x / kCellsPerBrick));
        }
    });
}

} // namespace

std::optional<Statistics> loadCoarseStatistics(const StoreReader& store, MemoryBudget& ram, int threads) {
    Statistics statistics = emptyStatistics(store.info(), ram);
    try {
        const std::size_t each = floatSpec(statistics.bricks).scratchBytes();
        const std::size_t workers =
            std::clamp(ram.freeBytes() / each, std::size_t{1},
                       static_cast<std::size_t>(threads > 0 ? threads : defaultThreads()));
        const Charge scratch = ram.charge(workers * each, "reading statistics");
        const StatisticsReader reader(store, {"brick_max", "brick_min"});
        if (reader.version() == kOldestStatistics)
            return std::nullopt;
        reader.summary(statistics);
        if (!reader.knowsFills() && !isAddress(store.path()) &&
            mayHaveFills({statistics.lowest, statistics.highest, statistics.histogram}, store.info()))
            return std::nullopt; // they are looked for in the voxels
        reader.pair("brick_min", statistics.wideMin, "brick_max", statistics.wideMax, statistics.bricks,
                    static_cast<int>(workers));
    } catch (const OutOfReach&) {
        throw;
    } catch (const BadFile&) { // loadStatistics() finds what can be done
        return std::nullopt;
    }
    {
        BufferPool pool(ram, 1, store.chunkBytes(), "reading brick means");
        gatherMeans(store, statistics, pool);
    }
    statistics.brickMin = statistics.wideMin;
    statistics.brickMax = statistics.wideMax;
    eachCellOfBricks(statistics.cells, statistics.bricks, threads, [&](std::size_t cell, std::size_t brick) {
        statistics.cellMin[cell] = statistics.wideMin[brick];
        statistics.cellMax[cell] = statistics.wideMax[brick];
    });
    return statistics;
}

Statistics boundsOfLevel(const Statistics& all, const VolumeInfo& info, int level, MemoryBudget& ram,
                         int threads) {
    VolumeInfo own = info;
    own.extentVoxels = levelExtent(info.extentVoxels, level);
    Statistics bounds = emptyStatistics(own, ram);
    bounds.lowest = all.lowest;
    bounds.highest = all.highest;
    const auto bound = [&](const glm::ivec3& cell) {
        // Samples of a cell and one around it, in voxels.
        const glm::ivec3 first = cell * kCellExtent;
        const glm::ivec3 low = glm::max(first - 1, glm::ivec3(0)) * (1 << level),
                         high = glm::min((first + kCellExtent + 1) * (1 << level), info.extentVoxels) - 1;
        const glm::ivec3 from = low / kBrickExtent, to = high / kBrickExtent;
        float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
        for (int z = from.z; z <= to.z; ++z)
            for (int y = from.y; y <= to.y; ++y)
                for (int x = from.x; x <= to.x; ++x) {
                    const std::size_t brick = linearIndex({x, y, z}, all.bricks);
                    lowest = std::min(lowest, all.brickMin[brick]);
                    highest = std::max(highest, all.brickMax[brick]);
                }
        const std::size_t at = linearIndex(cell, bounds.cells);
        bounds.cellMin[at] = lowest;
        bounds.cellMax[at] = highest;
    };
    parallelFor(static_cast<std::size_t>(bounds.cells.z), threads, [&](std::size_t layer) {
        for (int y = 0; y < bounds.cells.y; ++y)
            for (int x = 0; x < bounds.cells.x; ++x)
                bound({x, y, static_cast<int>(layer)});
    });
    std::fill(bounds.brickMin.begin(), bounds.brickMin.end(), std::numeric_limits<float>::infinity());
    std::fill(bounds.brickMax.begin(), bounds.brickMax.end(), -std::numeric_limits<float>::infinity());
    eachCellOfBricks(bounds.cells, bounds.bricks, 1, [&](std::size_t cell, std::size_t brick) {
        bounds.brickMin[brick] = std::min(bounds.brickMin[brick], bounds.cellMin[cell]);
        bounds.brickMax[brick] = std::max(bounds.brickMax[brick], bounds.cellMax[cell]);
    });
    bounds.wideMin = bounds.brickMin;
    bounds.wideMax = bounds.brickMax;
    return bounds;
}

} // namespace tessera

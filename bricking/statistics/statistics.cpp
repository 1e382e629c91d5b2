// bricking/statistics/statistics.cpp: see statistics.h and brick_rays.h. On disk: STORE/stats/cell_min,
// cell_max (float32 [z][y][x] over cells), brick_min, brick_max (the same over bricks, two layers around
// included; not in version 4). STORE/stats/rays/0 and 1 are uint8 [z][y][x][byte] over bricks: the parts of
// brick_rays.h. The group's attributes.tessera hold the version, the range, the whole histogram and the
// store's content hash. They also hold a CRC-32C of each of these arrays and of every layer of chunks of
// rays.
#include "bricking/statistics/statistics.h"

#include "bricking/statistics/brick_rays.h"
#include "bricking/statistics/fill_values.h"
#include "bricking/statistics/statistics_layout.h"
#include "bricking/statistics/statistics_pass.h"
#include "bricking/statistics/statistics_reader.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "bricking/store/remote_files.h"
#include "bricking/store/shard.h"
#include "bricking/store/store_files.h"
#include "bricking/store/zarr_array.h"
#include "core/base/address.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace tessera {
namespace fs = std::filesystem;
namespace {

/// Ranges of bricks from those of their cells.
void foldBricks(Statistics& statistics, int threads) {
    const glm::ivec3 cells = statistics.cells, bricks = statistics.bricks;
    std::fill(statistics.brickMin.begin(), statistics.brickMin.end(), statistics.highest);
    std::fill(statistics.brickMax.begin(), statistics.brickMax.end(), statistics.lowest);
    parallelFor(static_cast<std::size_t>(bricks.z), threads, [&](std::size_t layer) {
        const int first = static_cast<int>(layer) * kCellsPerBrick;
        for (int z = first; z < std::min(first + kCellsPerBrick, cells.z); ++z)
            for (int y = 0; y < cells.y; ++y) {
                std::size_t cell = linearIndex({0, y, z}, cells);
                const std::size_t row = linearIndex(glm::ivec3(0, y, z) / kCellsPerBrick, bricks);
                for (int x = 0; x < cells.x; ++x, ++cell) {
                    const std::size_t brick = row + static_cast<std::size_t>(x / kCellsPerBrick);
                    statistics.brickMin[brick] =
                        std::min(statistics.brickMin[brick], statistics.cellMin[cell]);
                    statistics.brickMax[brick] =
                        std::max(statistics.brickMax[brick], statistics.cellMax[cell]);
                }
            }
    });
}

/// For statistics without them: bounds for two layers around a brick, from all cells that touch it.
void boundWideRanges(Statistics& statistics) {
    statistics.wideMin = statistics.brickMin;
    statistics.wideMax = statistics.brickMax;
    const glm::ivec3 bricks = statistics.bricks;
    for (std::size_t brick = 0; brick < cellCount(bricks); ++brick) {
        const glm::ivec3 own = gridPosition(brick, bricks) * kCellsPerBrick;
        const glm::ivec3 first = glm::max(own - 1, glm::ivec3(0));
        const glm::ivec3 end = glm::min(own + kCellsPerBrick + 1, statistics.cells);
        for (int z = first.z; z < end.z; ++z)
            for (int y = first.y; y < end.y; ++y)
                for (int x = first.x; x < end.x; ++x) {
                    const std::size_t cell = linearIndex({x, y, z}, statistics.cells);
                    statistics.wideMin[brick] = std::min(statistics.wideMin[brick], statistics.cellMin[cell]);
                    statistics.wideMax[brick] = std::max(statistics.wideMax[brick], statistics.cellMax[cell]);
                }
    }
}

/// The hidden part of a cell or brick and of so many voxels around it.
Mask::Part partOf(const MaskedSource& masked, std::size_t at, const glm::ivec3& grid, int edge, int around) {
    const glm::ivec3 low = gridPosition(at, grid) * edge;
    return masked.mask().of(glm::max(low - around, glm::ivec3(0)),
                            glm::min(low + edge + around, masked.info().extentVoxels));
}

/// Reads the store's statistics; throws InputError if anything is missing, different or damaged.
/// @param threads  at most so many, each with scratchBytes()
/// @return false: they do not say whether there are fill values
bool readStatistics(const StoreReader& store, Statistics& statistics, int threads) {
    const StatisticsReader reader(store, {"brick_max", "brick_min", "cell_max", "cell_min"});
    reader.summary(statistics);
    reader.pair("cell_min", statistics.cellMin, "cell_max", statistics.cellMax, statistics.cells, threads);
    foldBricks(statistics, threads);
    if (reader.version() == kOldestStatistics)
        boundWideRanges(statistics);
    else
        reader.pair("brick_min", statistics.wideMin, "brick_max", statistics.wideMax, statistics.bricks,
                    threads);
    return reader.knowsFills();
}

/// For statistics that do not say it. Of a store on a server nothing is looked for: it would be fetched
/// whole.
void lookForFills(const StoreReader& store, Statistics& statistics, MemoryBudget& ram, int threads) {
    const WholeRange whole{statistics.lowest, statistics.highest, statistics.histogram};
    if (!mayHaveFills(whole, store.info()) || isAddress(store.path()))
        return;
    BufferPool pool(ram, threadCount(threads), store.chunkBytes(), "looking for fill values");
    try {
        statistics.fills = findFills(store, whole, pool, threads);
    } catch (const BadFile&) { // damaged voxels are told of where they are drawn
    }
}

} // namespace

int histogramBin(double value, double lowest, double highest) {
    if (!(value > lowest) || !(highest > lowest))
        return 0; // also for NaN
    return std::min(kHistogramBins - 1,
                    static_cast<int>(std::min(kHistogramBins - 1.0,
                                              (value - lowest) * kHistogramBins / (highest - lowest))));
}

void Statistics::brickRange(const BrickId& brick, int layers, float& lo, float& hi) const {
    TESSERA_CHECK(layers == 1 || layers == 2);
    const std::size_t at = linearIndex({brick.i, brick.j, brick.k}, bricks);
    lo = layers == 1 ? brickMin[at] : wideMin[at];
    hi = layers == 1 ? brickMax[at] : wideMax[at];
}

std::size_t statisticsFloorBytes(const VolumeInfo& info, int threads) {
    const std::size_t chunk = cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info.type);
    const std::size_t own = heldStatisticsBytes(info) + threadCount(threads) * chunk +
                            rayScratchBytes(info, threads) + kBrickRayParts * rayLayerBytes(info) +
                            scratchBytes(info);
    // A reader takes up to a quarter of what is free (store_reader.h).
    return (own + readerFloorBytes(info)) / 3 * 4 + 4;
}

Statistics loadStatistics(const StoreReader& store, MemoryBudget& ram, int threads) {
    Statistics statistics = emptyStatistics(store.info(), ram);
    {
        BufferPool pool(ram, 1, store.chunkBytes(), "reading brick means");
        gatherMeans(store, statistics, pool);
    }
    try {
        bool knowsFills = false;
        {
            const std::size_t each = scratchBytes(store.info());
            const std::size_t workers =
                std::clamp(ram.freeBytes() / each, std::size_t{1}, threadCount(threads));
            const Charge scratch = ram.charge(workers * each, "reading statistics");
            knowsFills = readStatistics(store, statistics, static_cast<int>(workers));
        }
        if (!knowsFills)
            lookForFills(store, statistics, ram, threads);
        return statistics;
    } catch (const OutOfReach&) { // to compute them would fetch all that there is
        throw;
    } catch (const InputError&) {
        // An optional cache: after any error the statistics are computed from the voxels.
    }
    std::fill(statistics.histogram.begin(), statistics.histogram.end(), std::uint64_t{0});
    BufferPool pool(ram, threadCount(threads), store.chunkBytes(), "computing statistics");
    gatherCells(store, statistics, pool, threads);
    WholeRange whole{statistics.lowest, statistics.highest, std::move(statistics.histogram)};
    gatherHistogram(store, whole, pool, threads);
    statistics.fills = findFills(store, whole, pool, threads);
    statistics.histogram = std::move(whole.histogram);
    foldBricks(statistics, threads);
    return statistics;
}

void hideMasked(Statistics& statistics, const MaskedSource& masked, MemoryBudget& ram, int threads) {
    const auto air = static_cast<float>(masked.airStored());
    const Charge charge = ram.charge(4 * sizeof(float) * cellCount(statistics.bricks), "hiding a part");
    const std::vector<float> means = statistics.brickMean;
    try {
        BufferPool pool(ram, 1, masked.chunkBytes(), "reading brick means");
        gatherMeans(masked, statistics, pool);
    } catch (...) {
        statistics.brickMean = means;
        throw;
    }
    const auto hide = [&](std::vector<float>& low, std::vector<float>& high, std::size_t at,
                          Mask::Part part) {
        low[at] = part == Mask::Part::all ? air : std::min(low[at], air);
        high[at] = part == Mask::Part::all ? air : std::max(high[at], air);
    };
    std::vector<std::size_t> changed; // bricks
    for (std::size_t brick = 0; brick < cellCount(statistics.bricks); ++brick)
        if (partOf(masked, brick, statistics.bricks, kBrickExtent, 2) != Mask::Part::none)
            changed.push_back(brick);
    parallelFor(changed.size(), threads, [&](std::size_t n) {
        const glm::ivec3 own = gridPosition(changed[n], statistics.bricks) * kCellsPerBrick;
        const glm::ivec3 count = glm::min(glm::ivec3(kCellsPerBrick), statistics.cells - own);
        for (std::size_t cell = 0; cell < cellCount(count); ++cell) {
            const std::size_t at = linearIndex(own + gridPosition(cell, count), statistics.cells);
            const Mask::Part part = partOf(masked, at, statistics.cells, kCellExtent, 1);
            if (part != Mask::Part::none)
                hide(statistics.cellMin, statistics.cellMax, at, part);
        }
    });
    const std::vector<float> wideMin = statistics.wideMin, wideMax = statistics.wideMax;
    foldBricks(statistics, threads);
    boundWideRanges(statistics);
    std::vector<std::uint8_t> isChanged(cellCount(statistics.bricks));
    for (const std::size_t brick : changed)
        isChanged[brick] = 1;
    for (std::size_t brick = 0; brick < isChanged.size(); ++brick)
        if (!isChanged[brick]) {
            statistics.wideMin[brick] = wideMin[brick];
            statistics.wideMax[brick] = wideMax[brick];
        }
}

// -- rays of bricks (brick_rays.h)

namespace {

/// Reads the rows of `bricks` that are new, layer by layer; only layers that have one.
void readRays(const StoreReader& store, const std::vector<std::uint8_t>& isNew, BrickRays& rays,
              MemoryBudget& ram, int threads) {
    const StoreFolder folder = openFolder(store.path());
    const Json group = readStatisticsGroup(folder, store);
    const std::string where = (store.path() / kStatisticsFile).string();
    const ArraySpec spec = raySpec(rays.bricks);
    const std::size_t perLayer = rayLayerBytes(store.info()) / kBrickRayBytes;
    const auto hasNew = [&](std::size_t layer) {
        const auto begin = isNew.begin() + static_cast<std::ptrdiff_t>(layer * perLayer);
        const auto end =
            isNew.begin() + static_cast<std::ptrdiff_t>(std::min((layer + 1) * perLayer, isNew.size()));
        return std::find(begin, end, 1) != end;
    };
    for (int part = 0; part < rays.parts; ++part)
        for (int layer = 0; layer < spec.layers(); ++layer)
            if (hasNew(static_cast<std::size_t>(layer)))
                tellArrayLayers(folder, rayPath(part), spec, layer, layer + 1);
    for (int part = 0; part < rays.parts; ++part)
        checkArrayMetadata(folder, rayPath(part), spec, store.path());
    BufferPool pool(ram, threadCount(threads), rayLayerBytes(store.info()), "reading rays of bricks");
    const Charge scratch = ram.charge(threadCount(threads) * spec.scratchBytes(), "reading rays of bricks");
    parallelFor(static_cast<std::size_t>(spec.layers()), threads, [&](std::size_t layer) {
        const std::size_t first = layer * perLayer, end = std::min(first + perLayer, isNew.size());
        if (!hasNew(layer))
            return;
        const BufferPool::Lease buffer(pool);
        const std::span<std::byte> bytes = buffer.bytes().first((end - first) * kBrickRayBytes);
        for (int part = 0; part < rays.parts; ++part) {
            readArrayLayer(folder, rayPath(part), spec, static_cast<int>(layer), bytes, store.path());
            const auto expected = integerAt(
                group, "/attributes/tessera/rays/" + std::to_string(part) + "/" + std::to_string(layer), 0,
                UINT32_MAX, where);
            if (crc32c(bytes) != expected)
                throw badFile((store.path() / rayPath(part)).string(),
                              "the array that stats/zarr.json describes", "another");
            for (std::size_t brick = first; brick < end; ++brick)
                if (isNew[brick])
                    std::memcpy(rays.row(rays.rowOf[brick]).data() +
                                    static_cast<std::size_t>(part) * kBrickRayBytes,
                                bytes.data() + (brick - first) * kBrickRayBytes, kBrickRayBytes);
        }
    });
}

} // namespace

BrickRays noBrickRays(const VolumeInfo& info, int parts, MemoryBudget& ram) {
    TESSERA_CHECK(parts >= 1 && parts <= kBrickRayParts);
    BrickRays rays;
    rays.bricks = brickGrid(info.extentVoxels);
    rays.parts = parts;
    rays.charges.push_back(ram.charge(cellCount(rays.bricks) * sizeof(std::uint32_t), "rays of bricks"));
    rays.rowOf.assign(cellCount(rays.bricks), BrickRays::kNoRow);
    return rays;
}

void addBrickRays(const StoreReader& store, std::span<const std::uint8_t> wanted, BrickRays& rays,
                  MemoryBudget& ram, int threads, const MaskedSource* masked) {
    TESSERA_CHECK(wanted.size() == rays.rowOf.size());
    const Charge flags = ram.charge(wanted.size(), "rays of bricks");
    std::vector<std::uint8_t> isNew(wanted.size());
    std::size_t rows = rays.rows;
    for (std::size_t brick = 0; brick < wanted.size(); ++brick)
        if (wanted[brick] && rays.rowOf[brick] == BrickRays::kNoRow) {
            isNew[brick] = 1;
            ++rows;
        }
    if (rows == rays.rows)
        return;
    const std::size_t pages = (rows + BrickRays::kRowsPerPage - 1) / BrickRays::kRowsPerPage;
    const std::size_t pageBytes = BrickRays::kRowsPerPage * rays.rowBytes();
    if (pages > rays.pages.size())
        rays.charges.push_back(ram.charge((pages - rays.pages.size()) * pageBytes, "rays of bricks"));
    while (rays.pages.size() < pages)
        rays.pages.emplace_back(pageBytes);
    for (std::size_t brick = 0; brick < wanted.size(); ++brick)
        if (isNew[brick])
            rays.rowOf[brick] = static_cast<std::uint32_t>(rays.rows++);
    const auto sample = [&](const ChunkSource& volume, const auto& takes) {
        BufferPool pool(ram, threadCount(threads), volume.chunkBytes(), "sampling rays");
        const std::size_t left = ram.freeBytes() - std::min(ram.freeBytes(), fieldBytes(threads));
        gatherRays(
            volume, nullptr, pool, ram, rayBandRows(volume.info(), left), threads, takes,
            [&](std::size_t brick, const std::array<BrickRayPart, kBrickRayParts>& parts) {
                const std::span<std::uint8_t> row = rays.row(rays.rowOf[brick]);
                for (std::size_t part = 0; part < static_cast<std::size_t>(rays.parts); ++part)
                    encode(parts[part], std::span<std::uint8_t, kBrickRayBytes>(
                                            row.data() + part * kBrickRayBytes, kBrickRayBytes));
            },
            [](int) {});
    };
    try {
        readRays(store, isNew, rays, ram, threads);
    } catch (const OutOfReach&) {
        throw;
    } catch (const InputError&) {
        // An optional cache, as in loadStatistics.
        sample(store, [&](std::size_t brick) { return isNew[brick] != 0; });
    }
    if (!masked)
        return;
    try {
        sample(*masked, [&](std::size_t brick) {
            return isNew[brick] != 0 &&
                   partOf(*masked, brick, rays.bricks, kBrickExtent, 1) != Mask::Part::none;
        });
    } catch (const InputError&) {
        // No room for sampling, or a chunk that cannot be read: predicted by what is hidden too.
    }
}

} // namespace tessera

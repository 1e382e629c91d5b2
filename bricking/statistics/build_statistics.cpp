// bricking/statistics/build_statistics.cpp: see statistics.h: buildStatistics(), a pass over a store that
// writes its statistics (statistics.cpp says where).
#include "bricking/statistics/brick_rays.h"
#include "bricking/statistics/fill_values.h"
#include "bricking/statistics/gathered_ranges.h"
#include "bricking/statistics/statistics.h"
#include "bricking/statistics/statistics_layout.h"
#include "bricking/statistics/statistics_pass.h"
#include "bricking/store/buffer_pool.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "bricking/store/slab_file.h"
#include "bricking/store/store_files.h"
#include "bricking/store/zarr_array.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace fs = std::filesystem;

namespace {

/// What buildStatistics() takes besides ranges of cells and bricks.
std::size_t buildingBytes(const VolumeInfo& info, int threads) {
    const std::size_t chunk = cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info.type);
    return sizeof(std::uint64_t) * kHistogramBins + threadCount(threads) * chunk +
           rayScratchBytes(info, threads) + kBrickRayParts * rayLayerBytes(info) + scratchBytes(info);
}
/// Bricks of a band of rays.
glm::ivec3 bandBricks(const VolumeInfo& info, int rows) {
    return {brickGrid(info.extentVoxels).x, rows, kRayLayers};
}
/// Of the ranges of cells and bricks in memory, while bands of so many rows of bricks are gathered.
std::size_t windowsBytes(const VolumeInfo& info, int rows) {
    const glm::ivec3 bricks = bandBricks(info, rows);
    return GatheredRanges::windowBytes(cellGrid(info.extentVoxels), kCellsPerBrick, bricks) +
           GatheredRanges::windowBytes(brickGrid(info.extentVoxels), 1, bricks);
}
std::size_t allRangesBytes(const VolumeInfo& info) {
    return GatheredRanges::bytes(cellGrid(info.extentVoxels)) +
           GatheredRanges::bytes(brickGrid(info.extentVoxels));
}
/// Of a row of chunks of an array of ranges.
std::size_t bandBytes(const glm::ivec3& grid) {
    const ArraySpec spec = floatSpec(grid);
    return cellCount({grid.x, spec.chunk.y, spec.chunk.z}) * sizeof(float);
}

/// Writes one array, and gives its checksum.
std::uint32_t writeRanges(const GatheredRanges& ranges, GatheredRanges::Side side, const glm::ivec3& grid,
                          const fs::path& folder, MemoryBudget& ram) {
    const ArraySpec spec = floatSpec(grid);
    const Charge charge = ram.charge(bandBytes(grid), "writing statistics");
    std::vector<float> band(bandBytes(grid) / sizeof(float));
    writeArrayMetadata(folder, spec);
    for (int layer = 0; layer < spec.layers(); ++layer) {
        const int first = layer * spec.chunk.z, slices = std::min(spec.chunk.z, grid.z - first);
        for (int row = 0; row < grid.y; row += spec.chunk.y) {
            const std::size_t slice = cellCount({grid.x, std::min(spec.chunk.y, grid.y - row), 1});
            for (int z = 0; z < slices; ++z)
                ranges.read(side, first + z, row,
                            std::span(band).subspan(static_cast<std::size_t>(z) * slice, slice));
            writeArrayBand(folder, spec, layer, row,
                           std::as_bytes(std::span(band).first(static_cast<std::size_t>(slices) * slice)));
        }
    }
    std::uint32_t crc = 0; // of [z][y][x]
    for (int z = 0; z < grid.z; ++z)
        for (int row = 0; row < grid.y; row += spec.chunk.y) {
            const auto rows =
                std::span(band).first(cellCount({grid.x, std::min(spec.chunk.y, grid.y - row), 1}));
            ranges.read(side, z, row, rows);
            crc = crc32c(std::as_bytes(rows), crc);
        }
    return crc;
}

} // namespace

std::size_t buildStatisticsFloorBytes(const VolumeInfo& info, int threads) {
    const std::size_t own = buildingBytes(info, threads) +
                            std::min(allRangesBytes(info), windowsBytes(info, 1)) +
                            bandBytes(cellGrid(info.extentVoxels));
    // A reader takes up to a quarter of what is free (store_reader.h).
    return (own + readerFloorBytes(info)) / 3 * 4 + 4;
}

void buildStatistics(const StoreReader& store, const fs::path& folder, MemoryBudget& ram, int threads,
                     const ShareDone& progress) {
    const VolumeInfo& info = store.info();
    const glm::ivec3 cells = cellGrid(info.extentVoxels), bricks = brickGrid(info.extentVoxels);
    const ArraySpec spec = raySpec(bricks);
    for (int part = 0; part < kBrickRayParts; ++part)
        writeArrayMetadata(folder / rayPath(part), spec);
    writeFile(folder / kRayGroupFile, storedText(plainGroup()));

    const Charge scratch = ram.charge(scratchBytes(info), "writing statistics");
    BufferPool pool(ram, threadCount(threads), store.chunkBytes(), "computing statistics");
    WholeRange whole;
    whole.histogram.resize(kHistogramBins);
    const auto [lowest, highest] = store.storedRange();
    whole.lowest = static_cast<float>(lowest);
    whole.highest = static_cast<float>(highest);
    Json crcs = Json::object(), rayCrcs = Json::array();
    std::optional<GatheredRanges> ofCells, ofBricks;
    std::optional<FillValues> fills; // none: the volume can have none
    {
        const Charge charge = ram.charge(kBrickRayParts * rayLayerBytes(info), "rays of bricks");
        std::array<std::vector<std::uint8_t>, kBrickRayParts> layer;
        for (std::vector<std::uint8_t>& part : layer)
            part.resize(rayLayerBytes(info));
        for (int part = 0; part < kBrickRayParts; ++part)
            rayCrcs.push_back(Json::array());
        const std::size_t perLayer = layer[0].size() / kBrickRayBytes;
        const auto brickDone = [&](std::size_t brick, const std::array<BrickRayPart, kBrickRayParts>& parts) {
            for (std::size_t part = 0; part < parts.size(); ++part)
                encode(parts[part],
                       std::span<std::uint8_t, kBrickRayBytes>(
                           layer[part].data() + brick % perLayer * kBrickRayBytes, kBrickRayBytes));
        };
        const auto groupDone = [&](int group) {
            if (progress)
                progress(static_cast<double>((group + 1) * kRayLayers) / bricks.z);
            const int layers = std::min(kRayLayers, bricks.z - group * kRayLayers);
            const std::size_t bytes = cellCount({bricks.x, bricks.y, layers}) * kBrickRayBytes;
            for (int part = 0; part < kBrickRayParts; ++part) {
                const auto used =
                    std::as_bytes(std::span(layer[static_cast<std::size_t>(part)]).first(bytes));
                writeArrayLayer(folder / rayPath(part), spec, group, used);
                rayCrcs[static_cast<std::size_t>(part)].push_back(crc32c(used));
            }
        };
        const std::size_t rays = rayScratchBytes(info, threads) + bandBytes(cells);
        const std::size_t room = ram.freeBytes() - std::min(ram.freeBytes(), rays);
        const bool areHeld = allRangesBytes(info) <= std::max(room, windowsBytes(info, 1));
        int rows = bricks.y;
        while (!areHeld && rows > 1 && windowsBytes(info, rows) > room / 2)
            rows = (rows + 1) / 2;
        if (areHeld) {
            ofCells.emplace(cells, kCellsPerBrick, ram);
            ofBricks.emplace(bricks, 1, ram);
        } else {
            requireDiskRoom(folder, 2 * allRangesBytes(info), "statistics of cells");
            ofCells.emplace(cells, kCellsPerBrick, bandBricks(info, rows), folder, ram);
            ofBricks.emplace(bricks, 1, bandBricks(info, rows), folder, ram);
        }
        const std::size_t left = ram.freeBytes() - std::min(ram.freeBytes(), fieldBytes(threads));
        WholePass pass{whole, *ofCells, *ofBricks};
        const FoundRange found = gatherRays(
            store, &pass, pool, ram, std::min(rows, rayBandRows(info, left)), threads,
            [](std::size_t) { return true; }, brickDone, groupDone);
        if (found != FoundRange{whole.lowest, whole.highest}) { // of a store by another hand
            whole.lowest = found.lowest;
            whole.highest = found.highest;
            std::fill(whole.histogram.begin(), whole.histogram.end(), std::uint64_t{0});
            gatherHistogram(store, whole, pool, threads);
        }
        if (mayHaveFills(whole, info))
            fills = findFills(store, whole, pool, threads);
    }
    const auto write = [&](const std::string& name, const GatheredRanges& ranges, const glm::ivec3& grid) {
        for (const auto& [ending, side] :
             {std::pair{"_min", GatheredRanges::Side::least}, {"_max", GatheredRanges::Side::most}})
            crcs[name + ending] = writeRanges(ranges, side, grid, folder / "stats" / (name + ending), ram);
    };
    write("cell", *ofCells, cells);
    write("brick", *ofBricks, bricks);

    Json group = plainGroup();
    group["attributes"]["tessera"] = {{"kind", "statistics"},
                                      {"version", kStatisticsVersion},
                                      {"store", store.contentHash()},
                                      {"lowest", whole.lowest},
                                      {"highest", whole.highest},
                                      {"histogram", whole.histogram},
                                      {"arrays", crcs},
                                      {"rays", rayCrcs}};
    if (fills)
        group["attributes"]["tessera"][kFillsKey] = fillsJson(*fills);
    seal(group);
    writeFile(folder / kStatisticsFile, storedText(group));
}

} // namespace tessera

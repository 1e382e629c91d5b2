// bricking/statistics.cpp: see statistics.h. On disk: STORE/stats/cell_min, cell_max (float32 [z][y][x] over
// cells), STORE/stats/histogram/<level> (uint16 [z][y][x][bin] over bricks), and in the group's
// attributes.tessera the range, the whole histogram, the store's content hash and a CRC-32C of every array.
#include "bricking/statistics.h"

#include "bricking/statistics_pass.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "bricking/store/crc32c.h"
#include "bricking/store/file_io.h"
#include "bricking/store/shard.h"
#include "bricking/store/zarr_array.h"
#include "core/error.h"
#include "core/threads.h"

#include <algorithm>
#include <numeric>

namespace tessera {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kMaxGroupBytes = 65536; // ours have about 2 KiB

ArraySpec cellSpec(const glm::ivec3& cells) {
    return {"float32", sizeof(float), cells, glm::min(cells, glm::ivec3(64, 64, 16)), 0};
}
ArraySpec histogramSpec(const glm::ivec3& bricks) {
    return {"uint16", sizeof(std::uint16_t), bricks, glm::min(bricks, glm::ivec3(16, 16, kHistogramLayers)),
            kHistogramBins};
}
std::string histogramPath(int level) {
    return "stats/histogram/" + std::to_string(level);
}

std::size_t heldBytes(const VolumeInfo& info) {
    return 2 * sizeof(float) * cellCount(cellGrid(info.extentVoxels)) +
           sizeof(float) * cellCount(brickGrid(info.extentVoxels)) + sizeof(std::uint64_t) * kHistogramBins;
}
std::size_t groupCounts(const VolumeInfo& info) {
    const glm::ivec3 bricks = brickGrid(info.extentVoxels);
    return cellCount({bricks.x, bricks.y, std::min(bricks.z, kHistogramLayers)}) * kHistogramBins;
}
std::size_t threadCount(int threads) {
    return static_cast<std::size_t>(threads > 0 ? threads : defaultThreads());
}
std::size_t scratchBytes(const VolumeInfo& info) {
    return std::max(cellSpec(cellGrid(info.extentVoxels)).scratchBytes(),
                    histogramSpec(brickGrid(info.extentVoxels)).scratchBytes());
}

/// Sized and charged, not yet filled.
Statistics emptyStatistics(const VolumeInfo& info, Ledger& ram) {
    Statistics statistics;
    statistics.charge = ram.charge(heldBytes(info), "statistics");
    statistics.cells = cellGrid(info.extentVoxels);
    statistics.bricks = brickGrid(info.extentVoxels);
    statistics.cellMin.resize(cellCount(statistics.cells));
    statistics.cellMax.resize(cellCount(statistics.cells));
    statistics.brickMean.resize(cellCount(statistics.bricks));
    statistics.histogram.resize(kHistogramBins);
    return statistics;
}

/// Both passes; `done` also sees the brick histograms of levels below `levels`, group by group.
void compute(const StoreReader& store, Statistics& statistics, Ledger& ram, int threads, int levels,
             const std::function<void(int, int, std::span<const std::uint16_t>)>& done) {
    BufferPool pool(ram, threadCount(threads), store.chunkBytes(), "computing statistics");
    const Charge charge = ram.charge(groupCounts(store.info()) * sizeof(std::uint16_t), "histograms");
    std::vector<std::uint16_t> counts(groupCounts(store.info()));
    gatherCells(store, statistics, pool, threads);
    gatherMeans(store, statistics, pool);
    for (int level = 0; level < levels; ++level)
        gatherHistograms(store, level, statistics.lowest, statistics.highest, pool, counts, threads,
                         [&](int group, std::span<const std::uint16_t> used) {
                             if (level == 0)
                                 for (std::size_t i = 0; i < used.size(); ++i)
                                     statistics.histogram[i % kHistogramBins] += used[i];
                             done(level, group, used);
                         });
}

std::span<std::byte> layerOf(std::vector<float>& cells, const ArraySpec& spec, int layer) {
    const std::size_t slice = cellCount({spec.grid.x, spec.grid.y, 1});
    const int first = layer * spec.chunk.z, end = std::min(first + spec.chunk.z, spec.grid.z);
    return std::as_writable_bytes(std::span(cells).subspan(slice * static_cast<std::size_t>(first),
                                                           slice * static_cast<std::size_t>(end - first)));
}

constexpr const char* kGroupFile = "stats/zarr.json";

/// The document of the statistics' group, its seal checked.
Json readGroup(const FileHandle& folder, const StoreReader& store) {
    const std::string where = (store.path() / kGroupFile).string();
    const auto text = readText(folder, kGroupFile, store.path(), kMaxGroupBytes);
    if (!text)
        throw badFile(where, "statistics", "none");
    Json group = parseJson(*text, where);
    checkSeal(group, where);
    return group;
}

/// Reads what the store holds; throws InputError when anything is missing, different or damaged.
void readStatistics(const StoreReader& store, Statistics& statistics) {
    const FileHandle folder = openFolder(store.path());
    const std::string where = (store.path() / kGroupFile).string();
    const Json group = readGroup(folder, store);
    const std::string root = "/attributes/tessera/";
    if (textAt(group, root + "store", where) != store.contentHash())
        throw badFile(where, "statistics of this store", "those of another");
    statistics.lowest = static_cast<float>(numberAt(group, root + "lowest", where));
    statistics.highest = static_cast<float>(numberAt(group, root + "highest", where));
    std::uint64_t voxels = 0;
    for (std::size_t bin = 0; bin < kHistogramBins; ++bin) {
        statistics.histogram[bin] = static_cast<std::uint64_t>(
            integerAt(group, root + "histogram/" + std::to_string(bin), 0, std::int64_t{1} << 62, where));
        voxels += statistics.histogram[bin];
    }
    if (voxels != store.info().voxelCount())
        throw badFile(where, "a histogram of all voxels", std::to_string(voxels) + " counts");
    const ArraySpec spec = cellSpec(statistics.cells);
    const auto readCells = [&](const char* name, std::vector<float>& cells) {
        const std::string relative = std::string("stats/") + name;
        checkArrayMetadata(folder, relative, spec, store.path());
        for (int layer = 0; layer < spec.layers(); ++layer)
            readArrayLayer(folder, relative, spec, layer, layerOf(cells, spec, layer), store.path());
        const auto expected = integerAt(group, root + "arrays/" + name, 0, UINT32_MAX, where);
        if (crc32c(std::as_bytes(std::span(cells))) != expected)
            throw badFile((store.path() / relative).string(), "the array that stats/zarr.json describes",
                          "another");
    };
    readCells("cell_min", statistics.cellMin);
    readCells("cell_max", statistics.cellMax);
}

} // namespace

int histogramBin(double value, double lowest, double highest) {
    if (!(value > lowest) || !(highest > lowest))
        return 0; // also where a value is not a number
    return std::min(kHistogramBins - 1,
                    static_cast<int>(std::min(kHistogramBins - 1.0,
                                              (value - lowest) * kHistogramBins / (highest - lowest))));
}

void Statistics::brickRange(const BrickId& brick, float& lo, float& hi) const {
    const glm::ivec3 first = glm::ivec3(brick.i, brick.j, brick.k) * kCellsPerBrick;
    const glm::ivec3 end = glm::min(first + kCellsPerBrick, cells);
    lo = highest;
    hi = lowest;
    for (int z = first.z; z < end.z; ++z)
        for (int y = first.y; y < end.y; ++y)
            for (int x = first.x; x < end.x; ++x) {
                lo = std::min(lo, cellMin[linearIndex({x, y, z}, cells)]);
                hi = std::max(hi, cellMax[linearIndex({x, y, z}, cells)]);
            }
}

std::size_t statisticsFloorBytes(const VolumeInfo& info, int threads) {
    const std::size_t chunk = cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info.type);
    const std::size_t own = heldBytes(info) + threadCount(threads) * chunk +
                            groupCounts(info) * sizeof(std::uint16_t) + scratchBytes(info);
    // A reader takes up to a quarter of what is free (store_reader.h).
    return (own + readerFloorBytes(info)) / 3 * 4 + 4;
}

void buildStatistics(const StoreReader& store, const fs::path& folder, Ledger& ram, int threads) {
    const VolumeInfo& info = store.info();
    Statistics statistics = emptyStatistics(info, ram);
    const Charge scratch = ram.charge(scratchBytes(info), "writing statistics");
    const ArraySpec histograms = histogramSpec(statistics.bricks);
    for (int level = 0; level < kLevelCount; ++level)
        writeArrayMetadata(folder / histogramPath(level), histograms);
    const Json plainGroup = {{"zarr_format", 3}, {"node_type", "group"}, {"attributes", Json::object()}};
    writeFile(folder / "stats/histogram/zarr.json", plainGroup.dump(1) + "\n");

    Json crcs = Json::object();
    std::array<std::uint32_t, kLevelCount> histogramCrcs{};
    compute(store, statistics, ram, threads, kLevelCount,
            [&](int level, int group, std::span<const std::uint16_t> used) {
                writeArrayLayer(folder / histogramPath(level), histograms, group, std::as_bytes(used));
                std::uint32_t& crc = histogramCrcs[static_cast<std::size_t>(level)];
                crc = crc32c(std::as_bytes(used), crc);
            });
    for (int level = 0; level < kLevelCount; ++level)
        crcs["histogram" + std::to_string(level)] = histogramCrcs[static_cast<std::size_t>(level)];
    const ArraySpec cells = cellSpec(statistics.cells);
    const auto writeCells = [&](const char* name, std::vector<float>& values) {
        writeArrayMetadata(folder / "stats" / name, cells);
        for (int layer = 0; layer < cells.layers(); ++layer)
            writeArrayLayer(folder / "stats" / name, cells, layer, layerOf(values, cells, layer));
        crcs[name] = crc32c(std::as_bytes(std::span(values)));
    };
    writeCells("cell_min", statistics.cellMin);
    writeCells("cell_max", statistics.cellMax);

    Json group = plainGroup;
    group["attributes"]["tessera"] = {
        {"kind", "statistics"},          {"store", store.contentHash()},      {"lowest", statistics.lowest},
        {"highest", statistics.highest}, {"histogram", statistics.histogram}, {"arrays", crcs}};
    seal(group);
    writeFile(folder / kGroupFile, group.dump(1) + "\n");
}

Statistics loadStatistics(const StoreReader& store, Ledger& ram, int threads) {
    Statistics statistics = emptyStatistics(store.info(), ram);
    {
        BufferPool pool(ram, 1, store.chunkBytes(), "reading brick means");
        gatherMeans(store, statistics, pool);
    }
    try {
        const Charge scratch = ram.charge(scratchBytes(store.info()), "reading statistics");
        readStatistics(store, statistics);
        return statistics;
    } catch (const InputError&) {
        // A cache, never required: whatever was wrong with it, the voxels themselves tell.
    }
    std::fill(statistics.histogram.begin(), statistics.histogram.end(), std::uint64_t{0});
    compute(store, statistics, ram, threads, 1, [](int, int, std::span<const std::uint16_t>) {});
    return statistics;
}

BrickHistograms loadBrickHistograms(const StoreReader& store, int level, Ledger& ram) {
    TESSERA_CHECK(level >= 0 && level < kLevelCount);
    BrickHistograms histograms;
    histograms.bricks = brickGrid(store.info().extentVoxels);
    const ArraySpec spec = histogramSpec(histograms.bricks);
    const std::size_t counts = cellCount(histograms.bricks) * kHistogramBins;
    histograms.charge = ram.charge(counts * sizeof(std::uint16_t), "brick histograms");
    const Charge scratch = ram.charge(spec.scratchBytes(), "reading statistics");
    histograms.counts.resize(counts);
    const FileHandle folder = openFolder(store.path());
    checkArrayMetadata(folder, histogramPath(level), spec, store.path());
    const std::size_t slice = cellCount({spec.grid.x, spec.grid.y, 1}) * kHistogramBins;
    for (int layer = 0; layer < spec.layers(); ++layer) {
        const int first = layer * spec.chunk.z, end = std::min(first + spec.chunk.z, spec.grid.z);
        const auto part = std::span(histograms.counts)
                              .subspan(slice * static_cast<std::size_t>(first),
                                       slice * static_cast<std::size_t>(end - first));
        readArrayLayer(folder, histogramPath(level), spec, layer, std::as_writable_bytes(part), store.path());
    }
    const std::string where = (store.path() / kGroupFile).string();
    const Json group = readGroup(folder, store);
    const std::string root = "/attributes/tessera/";
    const auto expected =
        integerAt(group, root + "arrays/histogram" + std::to_string(level), 0, UINT32_MAX, where);
    if (textAt(group, root + "store", where) != store.contentHash() ||
        crc32c(std::as_bytes(std::span(histograms.counts))) != expected)
        throw badFile(where, "brick histograms of this store", "others");
    return histograms;
}

} // namespace tessera

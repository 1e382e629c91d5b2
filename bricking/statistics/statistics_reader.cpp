// bricking/statistics/statistics_reader.cpp: see statistics_reader.h.
#include "bricking/statistics/statistics_reader.h"

#include "bricking/statistics/fill_values.h"
#include "bricking/statistics/statistics_layout.h"
#include "bricking/store/codec.h"
#include "core/base/brick.h"
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>

namespace tessera {
namespace {

const std::string kStatisticsRoot = "/attributes/tessera/";

} // namespace

std::size_t heldStatisticsBytes(const VolumeInfo& info) {
    return 2 * sizeof(float) * cellCount(cellGrid(info.extentVoxels)) +
           5 * sizeof(float) * cellCount(brickGrid(info.extentVoxels)) +
           sizeof(std::uint64_t) * kHistogramBins;
}

Statistics emptyStatistics(const VolumeInfo& info, MemoryBudget& ram) {
    Statistics statistics;
    statistics.charge = ram.charge(heldStatisticsBytes(info), "statistics");
    statistics.cells = cellGrid(info.extentVoxels);
    statistics.bricks = brickGrid(info.extentVoxels);
    statistics.cellMin.resize(cellCount(statistics.cells));
    statistics.cellMax.resize(cellCount(statistics.cells));
    for (std::vector<float>* values : {&statistics.brickMean, &statistics.brickMin, &statistics.brickMax,
                                       &statistics.wideMin, &statistics.wideMax})
        values->resize(cellCount(statistics.bricks));
    statistics.histogram.resize(kHistogramBins);
    return statistics;
}

std::span<std::byte> layerOfArray(std::vector<float>& values, const ArraySpec& spec, int layer) {
    const std::size_t slice = cellCount({spec.grid.x, spec.grid.y, 1});
    const int first = layer * spec.chunk.z, end = std::min(first + spec.chunk.z, spec.grid.z);
    return std::as_writable_bytes(std::span(values).subspan(slice * static_cast<std::size_t>(first),
                                                            slice * static_cast<std::size_t>(end - first)));
}

StatisticsReader::StatisticsReader(const StoreReader& store, std::initializer_list<const char*> told)
    : store_(store), folder_(openFolder(store.path())), where_((store.path() / kStatisticsFile).string()) {
    const glm::ivec3& extent = store.info().extentVoxels;
    for (const char* name : told) {
        const ArraySpec spec = floatSpec(name[0] == 'c' ? cellGrid(extent) : brickGrid(extent));
        tellArrayLayers(folder_, std::string("stats/") + name, spec, 0, spec.layers());
    }
    group_ = readStatisticsGroup(folder_, store);
    version_ = integerAt(group_, kStatisticsRoot + "version", kOldestStatistics, kStatisticsVersion, where_);
}

void StatisticsReader::summary(Statistics& statistics) const {
    statistics.lowest = static_cast<float>(numberAt(group_, kStatisticsRoot + "lowest", where_));
    statistics.highest = static_cast<float>(numberAt(group_, kStatisticsRoot + "highest", where_));
    std::uint64_t voxels = 0;
    for (std::size_t bin = 0; bin < kHistogramBins; ++bin) {
        statistics.histogram[bin] = static_cast<std::uint64_t>(integerAt(
            group_, kStatisticsRoot + "histogram/" + std::to_string(bin), 0, std::int64_t{1} << 62, where_));
        voxels += statistics.histogram[bin];
    }
    if (voxels != store_.info().voxelCount())
        throw badFile(where_, "a histogram of all voxels", std::to_string(voxels) + " counts");
    if (group_["attributes"]["tessera"].contains(kFillsKey))
        statistics.fills = readFills(group_, kStatisticsRoot + kFillsKey, voxels, where_);
}

bool StatisticsReader::knowsFills() const {
    return group_["attributes"]["tessera"].contains(kFillsKey);
}

void StatisticsReader::pair(const char* low, std::vector<float>& lows, const char* high,
                            std::vector<float>& highs, const glm::ivec3& grid, int threads) const {
    struct Array {
        std::string name;
        std::vector<float>* values;
    };
    const std::array<Array, 2> arrays = {{{low, &lows}, {high, &highs}}};
    const ArraySpec spec = floatSpec(grid);
    for (const Array& array : arrays)
        checkArrayMetadata(folder_, "stats/" + array.name, spec, store_.path());
    const auto layers = static_cast<std::size_t>(spec.layers());
    parallelFor(2 * layers, threads, [&](std::size_t task) {
        const Array& array = arrays[task / layers];
        const int layer = static_cast<int>(task % layers);
        readArrayLayer(folder_, "stats/" + array.name, spec, layer, layerOfArray(*array.values, spec, layer),
                       store_.path());
    });
    parallelFor(2, threads, [&](std::size_t which) {
        const Array& array = arrays[which];
        const auto expected =
            integerAt(group_, kStatisticsRoot + "arrays/" + array.name, 0, UINT32_MAX, where_);
        if (crc32c(std::as_bytes(std::span(*array.values))) != expected)
            throw badFile((store_.path() / "stats" / array.name).string(),
                          "the array that stats/zarr.json describes", "another");
    });
}

} // namespace tessera

// bricking/statistics/statistics_layout.cpp: see statistics_layout.h.
#include "bricking/statistics/statistics_layout.h"

#include "bricking/statistics/statistics_pass.h" // kRayLayers
#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>

namespace tessera {

ArraySpec floatSpec(const glm::ivec3& grid) {
    return {"float32", sizeof(float), grid, glm::min(grid, glm::ivec3(64, 64, 16)), 0};
}

ArraySpec raySpec(const glm::ivec3& bricks) {
    return {"uint8", 1, bricks, glm::min(bricks, glm::ivec3(16, 16, kRayLayers)), kBrickRayBytes};
}

std::string rayPath(int part) {
    return "stats/rays/" + std::to_string(part);
}

std::size_t rayLayerBytes(const VolumeInfo& info) {
    const glm::ivec3 bricks = brickGrid(info.extentVoxels);
    return cellCount({bricks.x, bricks.y, std::min(bricks.z, kRayLayers)}) * kBrickRayBytes;
}

std::size_t threadCount(int threads) {
    return static_cast<std::size_t>(threads > 0 ? threads : defaultThreads());
}

std::size_t scratchBytes(const VolumeInfo& info) {
    return std::max(floatSpec(cellGrid(info.extentVoxels)).scratchBytes(),
                    raySpec(brickGrid(info.extentVoxels)).scratchBytes());
}

Json plainGroup() {
    return {{"zarr_format", 3}, {"node_type", "group"}, {"attributes", Json::object()}};
}

Json readStatisticsGroup(const StoreFolder& folder, const StoreReader& store) {
    constexpr std::uint64_t kMostBytes = 1 << 20; // ours have about 2 KiB and 30 bytes per 64 slices
    const std::string where = (store.path() / kStatisticsFile).string();
    const auto text = readText(folder, kStatisticsFile, store.path(), kMostBytes);
    if (!text)
        throw badFile(where, "statistics", "none");
    Json group = parseJson(*text, where);
    checkSeal(group, where);
    integerAt(group, "/attributes/tessera/version", kOldestStatistics, kStatisticsVersion, where);
    if (textAt(group, "/attributes/tessera/store", where) != store.contentHash())
        throw badFile(where, "statistics of this store", "those of another");
    return group;
}

} // namespace tessera

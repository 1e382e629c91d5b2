// render/plan/memory_plan.cpp: see memory_plan.h.
#include "render/plan/memory_plan.h"

#include "bricking/statistics/statistics.h" // statisticsFloorBytes
#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/contract/level_map.h"
#include "render/contract/preintegration.h"
#include "render/contract/ray_state.h" // rayCount
#include "render/empty_space/occupancy.h"
#include "render/plan/framing.h"

#include <algorithm>

namespace tessera {
namespace {

/// Memory of integrators beside a table: bins and sums.
std::size_t sumsBytes(std::size_t entries) {
    return (3 * entries + 5) * sizeof(glm::vec4);
}

} // namespace

bool MemoryPlan::grant(const char* what, std::size_t ramBytes, std::size_t gpuBytes, std::size_t ramParts,
                       std::size_t gpuParts, const char* replaces) {
    if (ramBytes > spareRam_ / ramParts || gpuBytes > spareGpu_ / gpuParts)
        return false;
    if (replaces)
        std::erase_if(needs_, [&](const Need& n) { return std::string(n.what) == replaces; });
    needs_.push_back({what, ramBytes, gpuBytes});
    return true;
}

std::size_t MemoryPlan::gpuBytes() const {
    std::size_t sum = 0;
    for (const Need& n : needs_)
        sum += n.gpuBytes;
    return sum;
}

std::size_t MemoryPlan::ramBytes() const {
    std::size_t sum = 0;
    for (const Need& n : needs_)
        sum += n.ramBytes;
    return sum;
}

std::size_t tableRamBytes(std::size_t entries, Integrator integrator) {
    const bool sums = integrator == Integrator::preintegrated || integrator == Integrator::preintegrated2d;
    const std::size_t colours =
        integrator == Integrator::preintegrated2d ? 2 * Preintegration2d::bytes(kLevelCount) : 0;
    return entries * (2 * sizeof(glm::vec4) + sizeof(int)) + (sums ? sumsBytes(entries) : 0) + colours;
}

std::size_t integratorGpuBytes(std::size_t entries, Integrator integrator) {
    return (integrator != Integrator::midpoint ? sumsBytes(entries) : 0) +
           (integrator == Integrator::preintegrated2d ? Preintegration2d::bytes(kLevelCount) : 0);
}

std::size_t tableGpuBytes(std::size_t entries, Integrator integrator) {
    return entries * sizeof(glm::vec4) + integratorGpuBytes(entries, integrator);
}

std::size_t ramAfterCamera(const VolumeInfo& info, int threads, MapScale scale, bool skipping) {
    return latticeCacheFloorBytes(info, threads) + stagingBytes(info) +
           LevelMap::bytes(brickGrid(info.extentVoxels)) +
           (skipping ? Occupancy::bytes(info.extentVoxels, scale) : 0);
}

std::size_t selectionBytes(const VolumeInfo& info) {
    return cellCount(brickGrid(info.extentVoxels)) * (sizeof(std::uint8_t) + sizeof(float));
}

std::size_t renderFloorBytes(const VolumeInfo& info, const glm::ivec2& imageSize, std::size_t bytesPerPixel,
                             int threads, Integrator integrator) {
    const int used = threads > 0 ? threads : defaultThreads();
    // The camera is fitted before there are levels, their maps and the cache.
    const std::size_t own =
        bytesPerPixel * rayCount(imageSize) + selectionBytes(info) +
        tableRamBytes(TransferTable::kMaxEntries, integrator) +
        std::max(ramAfterCamera(info, used, MapScale::bricks, true), framingBytes(info, used));
    // A reader takes up to a quarter of what is free (store_reader.h); the statistics' floor knows that.
    return statisticsFloorBytes(info, used) + own / 3 * 4 + 4;
}

} // namespace tessera

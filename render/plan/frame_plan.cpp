// render/plan/frame_plan.cpp: see frame_plan.h.
#include "render/plan/frame_plan.h"

#include "bricking/statistics/statistics.h" // statisticsFloorBytes
#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/contract/level_map.h"
#include "render/contract/preintegration.h"
#include "render/contract/ray_state.h" // rayCount
#include "render/empty_space/occupancy.h"
#include "render/plan/choose_integrator.h"
#include "render/plan/framing.h"
#include "render/plan/fusion.h"

#include <algorithm>
#include <atomic>
#include <cmath>

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

namespace {
/// Position error of filtered fetches, in voxels (docs/sampling.md, "Ray").
double slackOf(const Quality& quality) {
    return quality.fetch == Fetch::hardware ? 1.0 / 256 : 0.0;
}
} // namespace

void Layer::mapEmptySpace(const Quality& quality, MemoryBudget& ram) {
    const EdgeFunction edgeFunction = quality.edgeFunction;
    if (reduces()) {
        occupancy = {};
        if (optics.reduction == Reduction::average)
            bounds.clear();
        else
            bounds.fill(statistics, optics, info(), selection, mapScale, slackOf(quality), ram);
        return;
    }
    bounds.clear();
    const auto map = [&](Occupancy& occupancy, const TransferTable& shown) {
        const OccupancyInput input{statistics, shown, info(), selection, edgeFunction};
        if (occupancy.exists())
            occupancy.levelsChanged(input);
        else
            occupancy = Occupancy(input, mapScale, ram);
    };
    map(occupancy, table);
    if (mapsSurfaces)
        map(surfaceOccupancy, surfaceTable);
}

void Layer::functionChanged(const Quality& quality, MemoryBudget& ram, int threads) {
    if (reduces() || !occupancy.exists())
        mapEmptySpace(quality, ram);
    else
        occupancy.functionChanged({statistics, table, info(), selection, quality.edgeFunction}, threads);
}

ValueSummary summarise(const Statistics& statistics, const VolumeInfo& info, const std::string& unit) {
    ValueSummary summary;
    const double a = info.rescaleSlope * static_cast<double>(statistics.lowest) + info.rescaleIntercept;
    const double b = info.rescaleSlope * static_cast<double>(statistics.highest) + info.rescaleIntercept;
    summary.lowest = std::min(a, b);
    summary.highest = std::max(a, b);
    summary.isHu = info.unit == "HU" || unit == "HU";
    const glm::dvec3 spacing = info.spacingMm();
    summary.spacingMm = std::cbrt(spacing.x * spacing.y * spacing.z);
    for (const std::uint64_t count : statistics.histogram)
        summary.histogram.push_back(static_cast<double>(count));
    if (info.rescaleSlope < 0)
        std::reverse(summary.histogram.begin(), summary.histogram.end());
    const FillValues& fills = statistics.fills;
    if (fills.values.empty())
        return summary;
    const auto physical = [&](float stored) {
        return info.rescaleSlope * static_cast<double>(stored) + info.rescaleIntercept;
    };
    for (const FillValues::Value& fill : fills.values)
        summary.fills.push_back({physical(fill.value),
                                 static_cast<double>(fill.voxels) / static_cast<double>(info.voxelCount())});
    ValueSummary::Measured& measured = summary.measured;
    measured.lowest = std::min(physical(fills.lowest), physical(fills.highest));
    measured.highest = std::max(physical(fills.lowest), physical(fills.highest));
    measured.histogram.assign(fills.histogram.begin(), fills.histogram.end());
    if (info.rescaleSlope < 0)
        std::reverse(measured.histogram.begin(), measured.histogram.end());
    return summary;
}

double typicalVoxelMm(const VolumeInfo& info) {
    return std::cbrt(std::abs(glm::determinant(glm::dmat3(info.patientFromVoxel))));
}

namespace {

/// Invisible difference of a segment's colour.
constexpr double kAttenuationMatters = 1.0 / 255;

} // namespace

std::uint64_t PlanRevisions::next() {
    static std::atomic<std::uint64_t> last{0};
    return ++last;
}

Layers& Layers::operator=(Layers&& other) noexcept {
    for (std::size_t i = 0; i < std::min(all_.size(), other.all_.size()); ++i) {
        all_[i]->cache.reset(); // first: its threads read through what the next line replaces
        *all_[i] = std::move(*other.all_[i]);
    }
    for (std::size_t i = all_.size(); i < other.all_.size(); ++i)
        all_.push_back(std::move(other.all_[i]));
    return *this;
}

int FramePlan::channelsBeside() const {
    return keptLightChannels(view.lighting) + (layer().labels ? layer().labels->numbers().count : 0);
}

FurtherVolumes::FurtherVolumes() = default;
FurtherVolumes::FurtherVolumes(FurtherVolumes&&) noexcept = default;
FurtherVolumes& FurtherVolumes::operator=(FurtherVolumes&&) noexcept = default;
FurtherVolumes::~FurtherVolumes() = default;
void FurtherVolumes::add(std::unique_ptr<FurtherVolume> volume) {
    all_.push_back(std::move(volume));
}

Hulls ViewState::hulls() const {
    if (quality.sampling != Sampling::hulls)
        return {0, 0};
    constexpr int kWithShadows = 4;
    const bool shadows = std::any_of(lighting.lights.begin(), lighting.lights.end(),
                                     [](const Light& light) { return light.shadow; });
    Hulls hulls = quality.hulls;
    if (hulls.count == Hulls::kAutomatic)
        hulls.count = shadows ? kWithShadows : 1;
    return hulls;
}

Strides FramePlan::strides() const {
    Strides strides;
    strides.sampling = view.quality.sampling;
    strides.segmentVoxels = view.quality.stepVoxels;
    if (fused) {
        strides.uniformSegments = fusedSegments(*this);
        return strides;
    }
    if (layer().mixed())
        strides.map = &layer().levels;
    else
        strides.uniformSegments = 1 << mostStride(layer().selection, view.quality);
    return strides;
}

Integrator FramePlan::preintegration() const {
    const double change =
        view.quality.stepVoxels * typicalChangePerVoxel(layer().statistics, layer().table, info());
    const double length = view.quality.stepVoxels * typicalVoxelMm(info());
    return mayTake == Integrator::preintegrated2d &&
                   attenuationDifference(layer().table, change, length) > kAttenuationMatters
               ? Integrator::preintegrated2d
               : Integrator::preintegrated;
}

Integrator FramePlan::automaticIntegrator() const {
    return mayTake == Integrator::midpoint || layer().labels || fused ||
                   !isSharp(layer().statistics, layer().table, info(), view.quality.stepVoxels)
               ? Integrator::midpoint
               : preintegration();
}

std::vector<Integrator> FramePlan::integratorsToTry() const {
    if (layer().reduces())
        return {Integrator::midpoint};
    if (view.quality.integrator != Integrator::automatic || mayTake == Integrator::midpoint ||
        layer().labels || fused ||
        isSmooth(layer().statistics, layer().table, info(), view.quality.stepVoxels))
        return {layer().optics.integrator};
    return {Integrator::midpoint, preintegration()};
}

std::size_t FramePlan::gpuTableBytes(std::size_t entries) const {
    return tableGpuBytes(entries, view.quality.integrator == Integrator::automatic ? mayTake
                                                                                   : view.quality.integrator);
}

} // namespace tessera

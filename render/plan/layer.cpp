// render/plan/layer.cpp: see layer.h.
#include "render/plan/layer.h"

#include <algorithm>
#include <cmath>

namespace tessera {

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
    return summary;
}

double typicalVoxelMm(const VolumeInfo& info) {
    return std::cbrt(std::abs(glm::determinant(glm::dmat3(info.patientFromVoxel))));
}

} // namespace tessera

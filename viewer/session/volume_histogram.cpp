// viewer/session/volume_histogram.cpp: see volume_histogram.h.
#include "viewer/session/volume_histogram.h"

#include "core/base/brick.h"
#include "core/base/interrupt.h"
#include "render/contract/lattice.h"

#include <algorithm>

namespace tessera {

std::vector<double> volumeHistogram(const Layer& volume, double lowest, double highest, int bins) {
    constexpr std::size_t kMostSamples = 2'000'000;
    const VolumeInfo& info = volume.info();
    int level = 0;
    while (level < kLevelCount - 1 && cellCount(levelExtent(info.extentVoxels, level)) > kMostSamples)
        ++level;
    const glm::ivec3 extent = levelExtent(info.extentVoxels, level);
    std::vector<double> counts(static_cast<std::size_t>(bins));
    const double perValue = highest > lowest ? bins / (highest - lowest) : 0;
    SampleReader samples(*volume.cache, info.type);
    const glm::ivec3 chunks = ceilDiv(extent, kChunkExtent);
    for (int chunk = 0; chunk < static_cast<int>(cellCount(chunks));
         ++chunk) { // chunk by chunk: each read once
        checkInterrupted();
        const glm::ivec3 first = kChunkExtent * glm::ivec3(chunk % chunks.x, chunk / chunks.x % chunks.y,
                                                           chunk / (chunks.x * chunks.y));
        const glm::ivec3 end = glm::min(first + kChunkExtent, extent);
        for (int z = first.z; z < end.z; ++z)
            for (int y = first.y; y < end.y; ++y)
                for (int x = first.x; x < end.x; ++x) {
                    const double value =
                        info.rescaleSlope * samples.at(level, {x, y, z}) + info.rescaleIntercept;
                    const int bin = std::clamp(static_cast<int>((value - lowest) * perValue), 0, bins - 1);
                    ++counts[static_cast<std::size_t>(bin)];
                }
    }
    return counts;
}

} // namespace tessera

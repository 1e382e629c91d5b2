// bricking/analysis/lumen/value_noise.cpp: see value_noise.h.
#include "bricking/analysis/lumen/value_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <vector>

namespace tessera {
namespace {

constexpr double kNoiseReachMm = 20;
constexpr int kMostNoiseReach = 16, kLeastNoiseReach = 8; // voxels
constexpr int kNoiseBlock = 4;
constexpr double kDeviationOfMedian = 1.4826 / 1.41421356; // of one value, from differences of two
constexpr std::size_t kFewestPairs = 12;                   // least number of pairs of a usable block
constexpr double kQuietest = 0.25;                         // share of the blocks
constexpr double kClipped = 1 / 50.0; // of the voxels; fewer have the lowest value by chance

/// Standard deviation of the part of a normal distribution above its quantile p, relative to the whole.
double restOfNormal(double p) {
    constexpr std::array<std::array<double, 2>, 7> known = {
        {{0, 1}, {0.05, 0.90}, {0.2, 0.763}, {0.5, 0.603}, {0.8, 0.468}, {0.95, 0.372}, {1, 0.3}}};
    std::size_t i = 1;
    while (i + 1 < known.size() && known[i][0] < p)
        ++i;
    const double t = (p - known[i - 1][0]) / (known[i][0] - known[i - 1][0]);
    return known[i - 1][1] + t * (known[i][1] - known[i - 1][1]);
}

/// Values of a box of voxels.
struct NoiseBox {
    glm::ivec3 extent;
    std::vector<double> values;
    double at(const glm::ivec3& v) const { return values[linearIndex(v, extent)]; }
};

NoiseBox boxAround(LumenValues& values, const glm::dvec3& place) {
    const VolumeInfo& info = values.info();
    const glm::ivec3 reach = glm::clamp(glm::ivec3(kNoiseReachMm / info.spacingMm()),
                                        glm::ivec3(kLeastNoiseReach), glm::ivec3(kMostNoiseReach));
    const glm::ivec3 middle(glm::floor(place));
    const glm::ivec3 low = glm::max(middle - reach, glm::ivec3(0));
    const glm::ivec3 high = glm::min(middle + reach, info.extentVoxels - 1);
    NoiseBox box{glm::max(high - low + 1, glm::ivec3(1)), {}};
    box.values.reserve(cellCount(box.extent));
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x)
                box.values.push_back(values.voxel({x, y, z}));
    return box;
}

} // namespace

ValueNoise noiseAround(LumenValues& values, const glm::dvec3& place) {
    const NoiseBox box = boxAround(values, place);
    const double lowest = *std::min_element(box.values.begin(), box.values.end());
    const auto lows = std::count(box.values.begin(), box.values.end(), lowest);
    ValueNoise found;
    found.clippedShare = static_cast<double>(lows) / static_cast<double>(box.values.size());
    const bool clips = found.clippedShare >= kClipped;
    if (!clips)
        found.clippedShare = 0;

    const glm::dvec3 mm = values.info().spacingMm();
    const int coarsest = mm.z >= mm.x && mm.z >= mm.y ? 2 : mm.y >= mm.x ? 1 : 0;
    std::vector<double> deviations;
    const glm::ivec3 blocks = box.extent / kNoiseBlock;
    for (int b = 0; b < blocks.x * blocks.y * blocks.z; ++b) {
        const glm::ivec3 corner =
            kNoiseBlock * glm::ivec3(b % blocks.x, b / blocks.x % blocks.y, b / (blocks.x * blocks.y));
        std::vector<double> apart;
        double low = 0;
        for (int i = 0; i < kNoiseBlock * kNoiseBlock * kNoiseBlock; ++i) {
            const glm::ivec3 v = corner + glm::ivec3(i % kNoiseBlock, i / kNoiseBlock % kNoiseBlock,
                                                     i / (kNoiseBlock * kNoiseBlock));
            const double here = box.at(v);
            low += clips && here == lowest;
            for (int axis = 0; axis < 3; ++axis) {
                glm::ivec3 other = v;
                other[axis] += 2;
                if (axis == coarsest || other[axis] >= box.extent[axis])
                    continue;
                const double there = box.at(other);
                if (clips && (here == lowest || there == lowest))
                    continue;
                apart.push_back(std::abs(here - there));
            }
        }
        if (apart.size() < kFewestPairs)
            continue;
        // the median, so that an edge through the block does not count
        const auto middle = apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2);
        std::nth_element(apart.begin(), middle, apart.end());
        deviations.push_back(kDeviationOfMedian * *middle /
                             restOfNormal(low / (kNoiseBlock * kNoiseBlock * kNoiseBlock)));
    }
    if (deviations.empty())
        return found;
    const auto at = deviations.begin() +
                    static_cast<std::ptrdiff_t>(kQuietest * static_cast<double>(deviations.size() - 1));
    std::nth_element(deviations.begin(), at, deviations.end());
    found.deviation = *at;
    return found;
}

} // namespace tessera

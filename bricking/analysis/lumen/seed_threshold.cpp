// bricking/analysis/lumen/seed_threshold.cpp: see seed_threshold.h.
#include "bricking/analysis/lumen/seed_threshold.h"

#include "bricking/analysis/lumen/lumen_shape.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
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

namespace {

constexpr double kMostSeedRayMm = 100;
constexpr double kBeyondMm = 15;        // length of a ray behind the lumen
constexpr double kNoises = 6;           // in deviations: values further away are not of the lumen
constexpr double kBrighter = 1.5;       // times the distance from the threshold to the lumen's value
constexpr double kMostEdge = 1 / 4.0;   // the same; in a thin lumen the surroundings of the seed include wall
constexpr double kLeastEdge = 1 / 20.0; // of the range of all that rays meet
constexpr double kStayMm = 1.5;         // least thickness of a wall ...
constexpr int kStayVoxels = 3;          // ... or this many voxels
constexpr double kDeviationOfHalf = 1.4826; // from the median of deviations, of a normal distribution
constexpr double kNoisy = 1 / 60.0;         // noise, relative to the difference of lumen and wall

double medianOf(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Median of the 3^3 voxels around a place, and the noise of those around.
/// @param standard deviation of the 27: noise, and in a thin lumen its wall
SeedNeighbourhood around(LumenValues& values, const glm::dvec3& seed, double& spread) {
    const glm::ivec3 last = values.info().extentVoxels - 1;
    std::vector<double> near;
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x)
                near.push_back(values.voxel(
                    glm::clamp(glm::ivec3(glm::floor(seed)) + glm::ivec3(x, y, z), glm::ivec3(0), last)));
    SeedNeighbourhood found;
    found.lumen = medianOf(near);
    found.noise = noiseAround(values, seed).deviation;
    for (double& value : near)
        value = std::abs(value - found.lumen);
    spread = std::max(found.noise, kDeviationOfHalf * medianOf(near));
    return found;
}

void limit(SeedNeighbourhood& found) {
    if (!found.rule.below)
        found.rule.brightest = found.lumen + kBrighter * (found.lumen - found.rule.threshold);
}

/// Values along one ray.
struct SeedRay {
    std::vector<double> values;
    std::size_t stays = 1; // number of consecutive values that form a wall

    /// True if the last of them are beyond the lumen's noise, all on one side.
    bool endsAway(double lumen, double leave) const {
        if (values.size() < stays)
            return false;
        const double last = values.back() - lumen;
        return std::all_of(values.end() - static_cast<std::ptrdiff_t>(stays), values.end(),
                           [&](double value) { return (last < 0 ? lumen - value : value - lumen) > leave; });
    }
};

/// The value of the surroundings along one ray of values; NaN: none.
double wallAlong(const SeedRay& seedRay, double lumen, double leave) {
    const std::vector<double>& ray = seedRay.values;
    std::size_t i = 0;
    for (std::size_t away = 0; away < seedRay.stays; ++i) {
        if (i == ray.size())
            return std::nan("");
        const bool left = std::abs(ray[i] - lumen) > leave;
        const bool sameSide = away == 0 || (ray[i] < lumen) == (ray[i - 1] < lumen);
        away = !left ? 0 : sameSide ? away + 1 : 1;
    }
    i -= seedRay.stays;
    const double sign = ray[i] < lumen ? -1 : 1;
    // continues while it still departs from the lumen's by a tenth of the distance so far; noise may stop it
    // for a step
    double wall = ray[i];
    for (std::size_t waited = 0; ++i < ray.size() && waited < 3;) {
        const double more = sign * (ray[i] - wall);
        waited = more > 0.1 * std::abs(wall - lumen) ? 0 : waited + 1;
        if (more > 0)
            wall = ray[i];
    }
    return wall;
}

} // namespace

double SeedNeighbourhood::contrast() const {
    return std::abs(wall - lumen);
}

bool SeedNeighbourhood::noisy() const {
    return noise > kNoisy * contrast();
}

SeedNeighbourhood neighbourhoodOf(LumenValues& values, const glm::dvec3& seed, const std::string& name) {
    double spread = 0;
    SeedNeighbourhood found = around(values, seed, spread);
    const glm::dmat3 voxelFromMm = glm::inverse(glm::dmat3(values.info().patientFromVoxel));
    const glm::dvec3 n(values.info().extentVoxels);
    std::vector<SeedRay> rays;
    double lowest = found.lumen, highest = found.lumen;
    for (const glm::dvec3& direction : directions42()) {
        glm::dvec3 step = voxelFromMm * direction;
        const double mmPerStep = 0.5 / glm::length(step); // half a voxel
        step *= mmPerStep;
        SeedRay& ray = rays.emplace_back();
        ray.stays = static_cast<std::size_t>(std::clamp(kStayMm / mmPerStep, 1.0, 2.0 * kStayVoxels));
        glm::dvec3 at = seed;
        double left = kMostSeedRayMm; // the first position beyond the lumen's noise
        checkInterrupted();
        for (double mm = 0; mm < std::min(kMostSeedRayMm, left + kBeyondMm); mm += mmPerStep, at += step) {
            if (glm::any(glm::lessThan(at, glm::dvec3(0))) || glm::any(glm::greaterThan(at, n)))
                break;
            const double value = values.at(at);
            ray.values.push_back(value);
            lowest = std::min(lowest, value);
            highest = std::max(highest, value);
            if (left >= kMostSeedRayMm && ray.endsAway(found.lumen, kNoises * spread))
                left = mm;
        }
    }
    const double range = highest - lowest;
    const double leave = std::clamp(kNoises * spread, kLeastEdge * range, kMostEdge * range);
    std::vector<double> below, above; // values of walls, by their side of the lumen
    for (const SeedRay& ray : rays)
        if (const double wall = wallAlong(ray, found.lumen, leave); !std::isnan(wall))
            (wall < found.lumen ? below : above).push_back(wall);
    const std::vector<double>& walls = above.size() >= below.size() ? above : below;
    if (walls.empty() || highest <= lowest)
        throw badFile(name, "a point in a lumen, with a wall around it within 100 mm",
                      "one where values stay near " + std::to_string(found.lumen));
    found.rule.below = &walls == &above;
    found.wall = medianOf(walls);
    found.rule.threshold = 0.5 * (found.lumen + found.wall);
    limit(found);
    return found;
}

SeedNeighbourhood neighbourhoodOf(LumenValues& values, const glm::dvec3& seed, double threshold) {
    double spread = 0;
    SeedNeighbourhood found = around(values, seed, spread);
    found.rule = {threshold, found.lumen < threshold};
    found.wall = 2 * threshold - found.lumen;
    limit(found);
    return found;
}

} // namespace tessera

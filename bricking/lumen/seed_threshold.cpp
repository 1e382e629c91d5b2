// bricking/lumen/seed_threshold.cpp: see seed_threshold.h.
#include "bricking/lumen/seed_threshold.h"

#include "bricking/lumen/directions.h"
#include "core/error.h"
#include "core/interrupt.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

namespace tessera {
namespace {

constexpr double kMostSeedRayMm = 100;
constexpr double kBeyondMm = 15;      // that a ray goes on behind the lumen
constexpr double kNoises = 6;         // a value further off is none of the lumen
constexpr double kBrighter = 1.5;     // times the way from the threshold to the lumen
constexpr double kMostEdge = 1 / 4.0; // the same; where a lumen is thin, what is around the seed is wall, too
constexpr double kLeastEdge = 1 / 20.0; // of the range of all that rays meet

double medianOf(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Median and spread of the 3^3 voxels around a place.
SeedNeighbourhood around(LumenValues& values, const glm::dvec3& seed) {
    const glm::ivec3 last = values.info().extentVoxels - 1;
    std::vector<double> near;
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x)
                near.push_back(values.voxel(
                    glm::clamp(glm::ivec3(glm::floor(seed)) + glm::ivec3(x, y, z), glm::ivec3(0), last)));
    SeedNeighbourhood found;
    found.lumen = medianOf(near);
    for (double& value : near)
        value = std::abs(value - found.lumen);
    found.noise = 1.4826 * medianOf(near); // of a normal distribution, from the median of deviations
    return found;
}

void limit(SeedNeighbourhood& found) {
    if (!found.rule.below)
        found.rule.brightest = found.lumen + kBrighter * (found.lumen - found.rule.threshold);
}

/// The value at which what lies around begins, along one ray of values; NaN: none.
double wallAlong(const std::vector<double>& ray, double lumen, double leave) {
    std::size_t i = 0;
    while (i < ray.size() && std::abs(ray[i] - lumen) <= leave)
        ++i;
    if (i == ray.size())
        return std::nan("");
    const double sign = ray[i] < lumen ? -1 : 1;
    // on, as long as it still goes away from the lumen's by a tenth of the way so far; noise may hold it for
    // a step
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

SeedNeighbourhood neighbourhoodOf(LumenValues& values, const glm::dvec3& seed, const std::string& name) {
    SeedNeighbourhood found = around(values, seed);
    const glm::dmat3 voxelFromMm = glm::inverse(glm::dmat3(values.info().patientFromVoxel));
    const glm::dvec3 n(values.info().extentVoxels);
    std::vector<std::vector<double>> rays;
    double lowest = found.lumen, highest = found.lumen;
    for (const glm::dvec3& direction : directions42()) {
        glm::dvec3 step = voxelFromMm * direction;
        const double mmPerStep = 0.5 / glm::length(step); // half a voxel
        step *= mmPerStep;
        std::vector<double>& ray = rays.emplace_back();
        glm::dvec3 at = seed;
        double left = kMostSeedRayMm; // where it was first beyond the lumen's noise
        checkInterrupted();
        for (double mm = 0; mm < std::min(kMostSeedRayMm, left + kBeyondMm); mm += mmPerStep, at += step) {
            if (glm::any(glm::lessThan(at, glm::dvec3(0))) || glm::any(glm::greaterThan(at, n)))
                break;
            ray.push_back(values.at(at));
            lowest = std::min(lowest, ray.back());
            highest = std::max(highest, ray.back());
            if (std::abs(ray.back() - found.lumen) > kNoises * found.noise)
                left = std::min(left, mm);
        }
    }
    const double range = highest - lowest;
    const double leave = std::clamp(kNoises * found.noise, kLeastEdge * range, kMostEdge * range);
    std::vector<double> below, above; // walls, by their side of the lumen
    for (const auto& ray : rays)
        if (const double wall = wallAlong(ray, found.lumen, leave); !std::isnan(wall))
            (wall < found.lumen ? below : above).push_back(wall);
    const std::vector<double>& walls = above.size() >= below.size() ? above : below;
    if (walls.empty() || highest <= lowest)
        throw badFile(name, "a place in a lumen, with a wall around it within 100 mm",
                      "one where values stay near " + std::to_string(found.lumen));
    found.rule.below = &walls == &above;
    found.rule.threshold = 0.5 * (found.lumen + medianOf(walls));
    limit(found);
    return found;
}

SeedNeighbourhood neighbourhoodOf(LumenValues& values, const glm::dvec3& seed, double threshold) {
    SeedNeighbourhood found = around(values, seed);
    found.rule = {threshold, found.lumen < threshold};
    limit(found);
    return found;
}

} // namespace tessera

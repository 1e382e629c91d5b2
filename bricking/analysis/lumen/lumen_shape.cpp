// bricking/analysis/lumen/lumen_shape.cpp: see lumen_shape.h.
#include "bricking/analysis/lumen/lumen_shape.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

namespace tessera {

const std::array<glm::dvec3, 42>& directions42() {
    static const std::array<glm::dvec3, 42> all = [] {
        const double golden = (1 + std::sqrt(5.0)) / 2;
        std::array<glm::dvec3, 12> corners;
        std::size_t n = 0;
        for (const double a : {-1.0, 1.0})
            for (const double b : {-golden, golden}) {
                corners[n++] = {0, a, b};
                corners[n++] = {a, b, 0};
                corners[n++] = {b, 0, a};
            }
        std::array<glm::dvec3, 42> found;
        std::size_t filled = 0;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            found[filled++] = glm::normalize(corners[i]);
            for (std::size_t j = 0; j < i; ++j) // edges have length 2, other corners lie further apart
                if (glm::length(corners[i] - corners[j]) < 2.1)
                    found[filled++] = glm::normalize(corners[i] + corners[j]);
        }
        return found;
    }();
    return all;
}

namespace {

constexpr double kRayStep = 0.5;   // of the smallest spacing
constexpr double kLookStep = 0.25; // the same
constexpr double kThin = 4;        // smallest spacings
constexpr double kNearWalls = 1.5; // wall distances
constexpr double kPastPeak = 0.9;  // of the peak
constexpr double kMostEdgeMm = 3;  // from a threshold to the wall's peak
constexpr double kFarMm = 200;     // no lumen is wider

/// The first crossing of a value, in steps between samples; they begin below it and reach it.
double firstAt(const std::vector<double>& values, double value) {
    const auto at = std::find_if(values.begin() + 1, values.end(), [&](double v) { return v >= value; });
    const auto i = std::min(at - values.begin(), std::ssize(values) - 1);
    const double rise = *(values.begin() + i) - *(values.begin() + i - 1);
    return static_cast<double>(i) -
           (rise > 0 ? std::clamp((*(values.begin() + i) - value) / rise, 0.0, 1.0) : 0);
}

/// The nearest voxel of a row outside the set, from x in direction `sign`; at the latest beyond the volume.
int nextOutside(const VoxelSet& voxels, int x, int y, int z, int sign, int last) {
    const glm::ivec3 n = voxels.extentVoxels();
    while (x >= 0 && x < n.x && (last - x) * sign >= 0) {
        const std::uint32_t row =
            ~voxels.row(linearIndex({x >> 5, y >> 5, z >> 5}, voxels.chunks()), (y & 31) + 32 * (z & 31));
        if (sign > 0) {
            if (const std::uint32_t rest = row >> (x & 31))
                return x + std::countr_zero(rest);
            x = (x | 31) + 1;
        } else {
            if (const std::uint32_t rest = row << (31 - (x & 31)))
                return x - std::countl_zero(rest);
            x = (x & ~31) - 1;
        }
    }
    return x;
}

} // namespace

LumenShape::LumenShape(const VoxelSet& voxels, const VolumeInfo& info)
    : voxels_(voxels), patientFromVoxel_(info.patientFromVoxel),
      voxelFromPatient_(glm::inverse(info.patientFromVoxel)), mmFromStep_(info.patientFromVoxel),
      smallestMm_(std::min({info.spacingMm().x, info.spacingMm().y, info.spacingMm().z})) {
    const glm::dmat3 rows = glm::transpose(glm::dmat3(voxelFromPatient_));
    halfBoxPerMm_ = {glm::length(rows[0]), glm::length(rows[1]), glm::length(rows[2])};
}

double LumenShape::rayMm(const glm::dvec3& mm, const glm::dvec3& direction, double most) const {
    const double step = kRayStep * smallestMm_;
    const glm::dvec3 from = voxelOf(mm), along = glm::dmat3(voxelFromPatient_) * direction * step;
    const int count = static_cast<int>(most / step);
    for (int i = 1; i <= count; ++i)
        if (!voxels_.containsPlace(from + along * static_cast<double>(i)))
            return (i - 0.5) * step;
    return most;
}

double LumenShape::roughRadiusMm(const glm::dvec3& mm) const {
    std::array<double, 42> lengths;
    for (std::size_t i = 0; i < lengths.size(); ++i)
        lengths[i] = rayMm(mm, directions42()[i], kFarMm);
    std::nth_element(lengths.begin(), lengths.begin() + 10, lengths.end());
    return lengths[10];
}

double LumenShape::nearestOutsideMm(const glm::dvec3& place, double most, glm::dvec3& outside) const {
    const glm::ivec3 n = voxels_.extentVoxels();
    const glm::dvec3 alongX = mmFromStep_[0];
    double best2 = most * most;
    const auto look = [&](int x, int y, int z) {
        const glm::dvec3 middle = glm::dvec3(x, y, z) + 0.5, mm = mmFromStep_ * (middle - place);
        if (const double d2 = glm::dot(mm, mm); d2 < best2) {
            best2 = d2;
            outside = middle;
        }
    };
    const int z0 = static_cast<int>(std::floor(place.z)), y0 = static_cast<int>(std::floor(place.y));
    // layers and rows from the point outwards, so that the ball is small before many are visited
    const auto outwards = [](int middle, int i) { return middle + (i % 2 ? (i + 1) / 2 : -(i / 2)); };
    for (int i = 0; (i / 2 - 1) <= std::sqrt(best2) * halfBoxPerMm_.z; ++i) {
        const int z = outwards(z0, i);
        for (int j = 0; (j / 2 - 1) <= std::sqrt(best2) * halfBoxPerMm_.y; ++j) {
            const int y = outwards(y0, j);
            const glm::dvec3 row = mmFromStep_ * (glm::dvec3(0.5, y + 0.5, z + 0.5) - place);
            const double x = -glm::dot(row, alongX) / glm::dot(alongX, alongX); // where the row is nearest
            const glm::dvec3 away = row + x * alongX;
            const double left2 = best2 - glm::dot(away, away);
            if (left2 <= 0)
                continue;
            if (y < 0 || z < 0 || y >= n.y || z >= n.z) {
                look(static_cast<int>(std::lround(x)), y, z);
                continue;
            }
            const double half = std::sqrt(left2 / glm::dot(alongX, alongX));
            const int up = static_cast<int>(std::ceil(x)), down = up - 1;
            look(nextOutside(voxels_, up, y, z, 1, static_cast<int>(x + half)), y, z);
            look(nextOutside(voxels_, down, y, z, -1, static_cast<int>(std::floor(x - half))), y, z);
        }
    }
    return std::sqrt(best2);
}

double LumenShape::wallMm(const glm::dvec3& mm, LumenValues& values, const LumenRule& rule) const {
    if (!holds(mm))
        return 0;
    const glm::dvec3 place = voxelOf(mm);
    double most = kFarMm;
    for (const glm::dvec3& direction : directions42())
        most = std::min(most, rayMm(mm, direction, most));
    glm::dvec3 outside = place;
    // a ray's exit voxel has its centre at most a voxel's diagonal further
    const double far = nearestOutsideMm(place, most + 4 * glm::length(values.info().spacingMm()), outside);
    if (far <= 0)
        return 0;
    const double step = kLookStep * smallestMm_;
    // the crossing of trilinear values and threshold between two positions of a ray, mm
    const auto cross = [&](const glm::dvec3& along, double inner, double outer) {
        for (int i = 0; i < 8; ++i) {
            const double middle = 0.5 * (inner + outer);
            (rule.takes(values.at(place + along * middle)) ? inner : outer) = middle;
        }
        return 0.5 * (inner + outer);
    };
    if (!rule.takes(values.at(place)))
        return 0;
    const glm::dvec3 along = (outside - place) / far; // in voxels, a mm
    double inner = far;
    while (inner > 0 && !rule.takes(values.at(place + along * inner)))
        inner = std::max(0.0, inner - step);
    double wall = inner < far ? cross(along, inner, std::min(inner + step, far)) : far;
    if (wall > kThin * smallestMm_)
        return wall;
    // near the wall the direction to a voxel's centre is not that to the wall
    for (const glm::dvec3& direction : directions42()) {
        const glm::dvec3 ray = glm::dmat3(voxelFromPatient_) * direction;
        for (double t = step; t < wall; t += step)
            if (!rule.takes(values.at(place + ray * t)))
                wall = cross(ray, t - step, t);
    }
    return wall;
}

double LumenShape::edgeBeyondMm(const glm::dvec3& mm, double wallMm, LumenValues& values,
                                const LumenRule& rule, double lumen) const {
    const glm::dvec3 place = voxelOf(mm);
    const double step = kLookStep * smallestMm_, sign = rule.below ? 1 : -1;
    std::vector<double> beyond;
    std::vector<double> away; // from the lumen's value, along a ray
    for (const glm::dvec3& direction : directions42()) {
        const glm::dvec3 along = glm::dmat3(voxelFromPatient_) * direction * step;
        const auto next = [&] {
            away.push_back(sign * (values.at(place + along * static_cast<double>(away.size())) - lumen));
            return away.back();
        };
        away.clear();
        double peak = next();
        const auto near = static_cast<std::size_t>(kNearWalls * wallMm / step);
        while (away.size() <= near && rule.takes(lumen + sign * peak))
            peak = next();
        if (rule.takes(lumen + sign * peak))
            continue;
        const std::size_t end = away.size() + static_cast<std::size_t>(kMostEdgeMm / step);
        while (away.size() < end && away.back() >= kPastPeak * peak)
            peak = std::max(peak, next());
        beyond.push_back(step * (firstAt(away, 0.5 * peak) - firstAt(away, sign * (rule.threshold - lumen))));
    }
    if (beyond.size() < 2)
        return 0;
    const auto middle = beyond.begin() + static_cast<std::ptrdiff_t>(beyond.size() / 2);
    std::nth_element(beyond.begin(), middle, beyond.end());
    return std::max(0.0, *middle);
}

bool LumenShape::staysInside(const glm::dvec3& fromMm, const glm::dvec3& toMm, LumenValues& values,
                             const LumenRule& rule) const {
    const glm::dvec3 from = voxelOf(fromMm), to = voxelOf(toMm);
    const int count = std::max(1, static_cast<int>(std::ceil(glm::length(to - from) / kLookStep)));
    for (int i = 0; i <= count; ++i) {
        const glm::dvec3 place = from + (to - from) * (static_cast<double>(i) / count);
        if (!voxels_.containsPlace(place) || !values.inside(place, rule))
            return false;
    }
    return true;
}

} // namespace tessera

// viewer/session/disc_values.cpp: see disc_values.h.
#include "viewer/session/disc_values.h"

#include "core/base/interrupt.h"
#include "render/contract/lattice.h"
#include "render/contract/sampler.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

namespace tessera {

DiscValues discValues(BrickCache& cache, const VolumeInfo& info, const Measurement& circle) {
    constexpr double kMostSamples = 200'000;
    DiscValues values;
    const double radius = valueOf(circle);
    if (circle.kind != MeasurementKind::circle || !std::isfinite(radius) || radius <= 0)
        return values;
    const glm::dvec3 centre = circleCentre(circle), u = glm::normalize(circle.points[0] - centre);
    const glm::dvec3 normal =
        glm::normalize(glm::cross(circle.points[1] - circle.points[0], circle.points[2] - circle.points[0]));
    const glm::dvec3 v = glm::cross(normal, u), spacing = info.spacingMm();
    const double step = std::max(std::min({spacing.x, spacing.y, spacing.z}) / 2,
                                 std::sqrt(std::numbers::pi * radius * radius / kMostSamples));
    const int reach = static_cast<int>(std::floor(radius / step));
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    const glm::dvec3 extent(info.extentVoxels);
    LatticeReader samples(cache, info, 0, nullptr);
    double sum = 0, squares = 0, first = 0;
    for (int y = -reach; y <= reach; ++y) {
        checkInterrupted();
        for (int x = -reach; x <= reach; ++x) {
            const glm::dvec2 at = step * glm::dvec2(x, y);
            const glm::dvec3 voxel(voxelFromPatient * glm::dvec4(centre + at.x * u + at.y * v, 1));
            if (glm::dot(at, at) > radius * radius || glm::clamp(voxel, glm::dvec3(0), extent) != voxel)
                continue;
            const double value = info.rescaleSlope * fieldValue(samples, voxel, 1.0) + info.rescaleIntercept;
            if (values.samples == 0)
                values.least = values.most = first = value;
            values.least = std::min(values.least, value);
            values.most = std::max(values.most, value);
            sum += value - first; // from one of them, so that squares lose nothing
            squares += (value - first) * (value - first);
            ++values.samples;
        }
    }
    if (values.samples == 0)
        return values;
    const auto n = static_cast<double>(values.samples);
    values.mean = first + sum / n;
    values.deviation = std::sqrt(std::max(0.0, squares / n - sum / n * (sum / n)));
    return values;
}

} // namespace tessera

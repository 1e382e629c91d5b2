// render/backends/splat/splat_points.cpp: see splat_points.h.
#include "render/backends/splat/splat_points.h"

#include "core/base/error.h"
#include "render/geometry/mesh_bits.h"
#include "render/geometry/point_shape.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>

namespace tessera {
namespace {

constexpr double kDeviation = 0.5;     // of a point's radius
constexpr double kPointsBeforeEye = 3; // deviations before the eye

PointLook lookOf(const SceneMesh& mesh, double radiusMm, const SplatView& view,
                 const SplatSettings& settings) {
    const double mm = kDeviation * radiusMm, pixels = mm * view.scale / settings.lowPass;
    PointLook look;
    look.kernel = glm::mat3(static_cast<float>(mm));
    look.nearest = static_cast<float>(kPointsBeforeEye * mm);
    // In its middle a point has the mesh's opacity.
    const double depth = std::min(-std::log1p(-mesh.opacity), double{MeshBits::kOpaque});
    look.mass = static_cast<float>(depth * 2 * std::numbers::pi * mm * mm);
    look.filters = {FilterDepths::kLeast * pixels, FilterDepths::kMost * view.widening * pixels};
    look.colour = glm::vec3(mesh.colour.value_or(kMeshColour));
    return look;
}

} // namespace

SplatPoints::SplatPoints(const FramePlan& plan, const SplatView& view, const SplatSettings& settings,
                         const SliceOrder& order, int step, MemoryBudget& budget)
    : fromEnd_(order.fromEnd) {
    std::size_t count = 0;
    for (const SceneMesh& mesh : plan.view.meshes)
        count += mesh.shape->parts();
    charge_ = budget.charge(count * 2 * sizeof(ShownPoint), "points among splats"); // sorting takes as many
    points_.reserve(count);
    const glm::dmat4 toVoxels = glm::inverse(plan.info().patientFromVoxel);
    for (const SceneMesh& mesh : plan.view.meshes) {
        TESSERA_CHECK(dynamic_cast<const PointShape*>(mesh.shape.get()));
        const auto number = static_cast<std::uint32_t>(looks_.size());
        looks_.emplace_back();
        mesh.shape->forEachBall([&](const glm::dvec3& centre, double radiusMm) {
            if (looks_.back().mass == 0)
                looks_.back() = lookOf(mesh, radiusMm, view, settings);
            const glm::dvec3 voxel(toVoxels * glm::dvec4(centre, 1));
            if (mesh.clipped && plan.view.part.any() && !plan.view.part.keeps(voxel, 0))
                return;
            constexpr double kFarthest = 1 << 30;
            const double sheet = std::floor(voxel[order.axis] / step);
            points_.push_back({glm::vec3(view.place(voxel)), number,
                               static_cast<std::int32_t>(std::clamp(sheet, -kFarthest, kFarthest))});
        });
    }
    std::stable_sort(points_.begin(), points_.end(), [this](const ShownPoint& a, const ShownPoint& b) {
        return fromEnd_ ? b.sheet < a.sheet : a.sheet < b.sheet;
    });
}

std::span<const ShownPoint> SplatPoints::next() {
    std::size_t end = taken_;
    while (end < points_.size() && points_[end].sheet == points_[taken_].sheet)
        ++end;
    const auto of = std::span<const ShownPoint>(points_).subspan(taken_, end - taken_);
    taken_ = end;
    return of;
}

std::span<const ShownPoint> SplatPoints::next(int sheet) {
    if (taken_ == points_.size() ||
        (fromEnd_ ? points_[taken_].sheet < sheet : points_[taken_].sheet > sheet))
        return {};
    return next();
}

} // namespace tessera

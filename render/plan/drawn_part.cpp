// render/plan/drawn_part.cpp: see drawn_part.h.
#include "render/plan/drawn_part.h"

#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace tessera {
namespace {

constexpr double kUnbounded = 1e30; // a float holds it

/// Between two planes in patient space: low <= dot(normal, p) <= high, mm.
RaySlab<double> slabOf(const VolumeInfo& info, const glm::dvec3& normal, double low, double high) {
    const glm::dmat3 linear(info.patientFromVoxel);
    const double origin = glm::dot(normal, glm::dvec3(info.patientFromVoxel[3]));
    return {glm::transpose(linear) * normal, std::max(low - origin, -kUnbounded),
            std::min(high - origin, kUnbounded)};
}

glm::dvec3 middleOf(const VolumeInfo& info) {
    return glm::dvec3(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
}

/// The crossings of a plane with the edges of the volume's box; mm.
std::vector<glm::dvec3> crossSection(const VolumeInfo& info, const glm::dvec3& point,
                                     const glm::dvec3& normal) {
    std::vector<glm::dvec3> found;
    const auto corner = [&](int n) {
        const glm::dvec3 at = glm::dvec3(info.extentVoxels) * glm::dvec3(n & 1, (n >> 1) & 1, n >> 2);
        return glm::dvec3(info.patientFromVoxel * glm::dvec4(at, 1));
    };
    for (int n = 0; n < 8; ++n)
        for (int axis = 0; axis < 3; ++axis) {
            if (n >> axis & 1)
                continue;
            const glm::dvec3 a = corner(n), b = corner(n | 1 << axis);
            const double da = glm::dot(a - point, normal), db = glm::dot(b - point, normal);
            if (da == 0)
                found.push_back(a);
            if (db == 0 || (da < 0) != (db < 0))
                found.push_back(da == db ? b : a + da / (da - db) * (b - a));
        }
    return found;
}

} // namespace

void DrawnPart::clip(RayFrame<double>& frame) const {
    TESSERA_CHECK(slabs.size() <= static_cast<std::size_t>(kMostSlabs));
    frame.slabCount = static_cast<int>(slabs.size());
    std::copy(slabs.begin(), slabs.end(), frame.slabs.begin());
    frame.flat = flat;
    frame.cuts = cuts.get();
    if (!slice || frame.perspective)
        return;
    const RaySlab<double>& first = slabs.front();
    const double middle = 0.5 * (first.low + first.high), along = glm::dot(first.normal, frame.toCentre);
    constexpr double kFacing = 0.5; // cosine
    if (!(std::abs(middle) < kUnbounded / 4) ||
        std::abs(along) < kFacing * glm::length(first.normal) * glm::length(frame.toCentre))
        return;
    frame.centre += (middle - glm::dot(first.normal, frame.centre)) / along * frame.toCentre;
}

bool DrawnPart::meets(const glm::dvec3& low, const glm::dvec3& high) const {
    const glm::dvec3 middle = 0.5 * (low + high), half = 0.5 * (high - low);
    for (const RaySlab<double>& slab : slabs) {
        const double at = glm::dot(slab.normal, middle), reach = glm::dot(glm::abs(slab.normal), half);
        if (at + reach < slab.low || at - reach > slab.high)
            return false;
    }
    return !cuts || cuts->mayKeep(low, high);
}

bool DrawnPart::keeps(const glm::dvec3& point, double tolerance) const {
    for (const RaySlab<double>& slab : slabs) {
        const double at = glm::dot(slab.normal, point), reach = tolerance * glm::length(slab.normal);
        if (at < slab.low - reach || at > slab.high + reach)
            return false;
    }
    return !cuts || cuts->keeps(point, tolerance);
}

namespace {

/// Convex cuts: f(slabs of a body, the kept side).
template <typename Visit> void forEachBody(const Cuts& cuts, const VolumeInfo& info, const Visit& visit) {
    for (const CropBox& box : cuts.boxes) {
        checkBox(box, "crop");
        std::vector<RaySlab<double>> slabs;
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 normal(0);
            normal[axis] = 1;
            slabs.push_back(box.space == CropBox::Space::patient
                                ? slabOf(info, normal, box.low[axis], box.high[axis])
                                : RaySlab<double>{normal, box.low[axis], box.high[axis]});
        }
        visit(slabs, box.keep);
    }
    for (const CutPlane& plane : cuts.planes) {
        checkPlane(plane, "cut plane");
        const glm::dvec3 normal = glm::normalize(plane.keep == Keep::inside ? plane.normal : -plane.normal);
        visit({slabOf(info, normal, glm::dot(normal, plane.point), 2 * kUnbounded)}, Keep::inside);
    }
}

} // namespace

OwnCuts ownCuts(const Cuts& cuts, const VolumeInfo& info) {
    if (!cuts.scissors.empty())
        throw InputError("volumes[].cuts.scissors: expected none in a scene of several volumes, found " +
                         std::to_string(cuts.scissors.size()));
    OwnCuts own;
    forEachBody(cuts, info, [&](const std::vector<RaySlab<double>>& slabs, Keep keep) {
        own.exact.add(slabs, keep);
        for (const RaySlab<double>& slab : slabs) {
            leaf::CutSlab s;
            for (int axis = 0; axis < 3; ++axis)
                s.normal[axis] = static_cast<float>(slab.normal[axis]);
            s.low = static_cast<float>(slab.low), s.high = static_cast<float>(slab.high);
            s.endsBody = &slab == &slabs.back();
            s.keepsOutside = keep == Keep::outside;
            own.slabs.push_back(s);
        }
    });
    return own;
}

DrawnPart drawnPart(const Scene& scene, const VolumeInfo& info) {
    DrawnPart part;
    if (scene.mode == Mode::slice) {
        checkSlice(scene.slice, "slice");
        const SlicePose pose = poseOf(scene.slice, middleOf(info));
        const double at = glm::dot(pose.normal, pose.point), half = 0.5 * scene.slice.thicknessMm;
        part.slabs.push_back(slabOf(info, pose.normal, at - half, at + half));
        part.slice = true;
        part.flat = !(half > 0);
    }
    RayCuts others;
    // A kept convex cut becomes slabs of every ray, up to the largest number.
    const auto add = [&](const std::vector<RaySlab<double>>& slabs, Keep keep) {
        if (keep == Keep::inside && part.slabs.size() + slabs.size() <= static_cast<std::size_t>(kMostSlabs))
            part.slabs.insert(part.slabs.end(), slabs.begin(), slabs.end());
        else
            others.add(slabs, keep);
    };
    std::vector<const Cuts*> all = {&scene.cuts};
    if (scene.volumes.size() == 1)
        all.push_back(&scene.volumes.front().cuts);
    for (const Cuts* cuts : all) {
        forEachBody(*cuts, info, add);
        for (const Scissors& scissors : cuts->scissors) {
            checkScissors(scissors, "scissors");
            others.add(scissors, info);
        }
    }
    if (others.any() || drawsMeshes(scene) || scene.quality.sampling == Sampling::hulls)
        part.cuts = std::make_shared<const RayCuts>(std::move(others));
    return part;
}

Camera sliceCamera(const SlicePlane& slice, const VolumeInfo& info, const glm::ivec2& imageSize) {
    const SlicePose pose = poseOf(slice, middleOf(info));
    std::vector<glm::dvec3> points = crossSection(info, pose.point, pose.normal);
    if (points.empty())
        for (int n = 0; n < 8; ++n)
            points.push_back(glm::dvec3(
                info.patientFromVoxel *
                glm::dvec4(glm::dvec3(info.extentVoxels) * glm::dvec3(n & 1, (n >> 1) & 1, n >> 2), 1)));
    constexpr double kFar = std::numeric_limits<double>::infinity();
    glm::dvec2 low(kFar), high(-kFar);
    for (const glm::dvec3& p : points) {
        const glm::dvec2 at(glm::dot(p - pose.point, pose.right), glm::dot(p - pose.point, pose.up));
        low = glm::min(low, at);
        high = glm::max(high, at);
    }
    constexpr double kMargin = 1.03; // as that of other cameras (core/scene/camera.cpp)
    const glm::dvec2 middle = 0.5 * (low + high), half = 0.5 * (high - low);
    Camera camera;
    camera.projection = Projection::parallel;
    camera.focalPoint = pose.point + middle.x * pose.right + middle.y * pose.up;
    camera.viewUp = pose.up;
    const double aspect = static_cast<double>(imageSize.x) / imageSize.y;
    camera.parallelScale = kMargin * std::max({half.x / aspect, half.y, 1e-6});
    camera.position = camera.focalPoint + 4 * camera.parallelScale * pose.normal;
    return camera;
}

std::size_t leaveOutUndrawn(Selection& selection, const DrawnPart& part, const VolumeInfo& info,
                            int pitches) {
    if (!part.any())
        return 0;
    // A value lies between samples a pitch apart, a gradient between those of its neighbours; where levels
    // mix, blends reach half a sample of the coarsest.
    const double pitch = 1 << selection.finest();
    const double reach = selection.uniform() ? (pitches > 0 ? 2 + pitches : 1) * pitch + 1
                                             : (pitches > 0 ? 2 : 1) * kBrickExtent + 1;
    std::size_t left = 0;
    for (int k = 0; k < selection.bricks.z; ++k)
        for (int j = 0; j < selection.bricks.y; ++j)
            for (int i = 0; i < selection.bricks.x; ++i) {
                std::uint8_t& level = selection.levels[linearIndex({i, j, k}, selection.bricks)];
                const glm::dvec3 low = static_cast<double>(kBrickExtent) * glm::dvec3(i, j, k);
                const glm::dvec3 high =
                    glm::min(low + static_cast<double>(kBrickExtent), glm::dvec3(info.extentVoxels));
                if (level == Selection::kEmpty || part.meets(low - reach, high + reach))
                    continue;
                --selection.counts[level];
                level = Selection::kEmpty;
                ++left;
            }
    selection.counts[Selection::kEmpty] += left;
    return left;
}

} // namespace tessera

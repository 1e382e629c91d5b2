// render/backends/native/native_shadows.cpp: see native_shadows.h.
#include "render/backends/native/native_shadows.h"

#include "core/base/error.h"
#include "render/backends/native/native_scene.h"

#include <algorithm>
#include <memory>

namespace tessera {

/// Surfaces take light, and some gradients are left to the scalar text.
bool NativeShadows::canCast(const FramePlan& plan) {
    const Optics& optics = plan.layer().optics;
    const bool isPlain = optics.gradient != Gradient::analytic && optics.gradient != Gradient::cubic;
    return optics.surfaces.empty() && (isPlain || !optics.grades());
}

NativeShadows::NativeShadows(const FramePlan& plan, const HostPlane& plane,
                             const std::vector<std::unique_ptr<HostPlane>>& labels,
                             const native::PacketTarget& target)
    : lanes_(target.lanes()) {
    Strides strides; // as ShadowMaps has them
    strides.map = plan.layer().mixed() ? &plan.layer().levels : nullptr;
    strides.segmentVoxels = plan.view.shadowQuality.stepVoxels;
    const Occupancy* const occupancy =
        plan.view.quality.skipping && plan.layer().occupancy.exists() ? &plan.layer().occupancy : nullptr;
    const std::vector<std::unique_ptr<HostPlane>> none;
    scene_ = packetSceneOf({plan, plane, none, labels, strides, false, false, occupancy, nullptr, nullptr});
    march_ = target.shadows(scene_);
}

bool NativeShadows::along(std::span<const SegmentedRay<float>> rays, std::span<const float> mmAtEntry,
                          float dark, std::vector<LightLeft>& room,
                          std::span<std::span<const LightLeft>> samples) const {
    const auto lanes = static_cast<std::size_t>(lanes_);
    TESSERA_CHECK(!rays.empty() && rays.size() <= lanes && mmAtEntry.size() == rays.size() &&
                  samples.size() == rays.size());
    native::PacketJob job;
    native::PacketShadows out;
    out.dark = dark;
    static_assert(sizeof(LightLeft) == 2 * sizeof(float));
    std::size_t needed = 0;
    for (const SegmentedRay<float>& ray : rays)
        needed += 2 * static_cast<std::size_t>(ray.count);
    if (room.size() < needed)
        room.resize(needed);
    LightLeft* next = room.data();
    for (std::size_t lane = 0; lane < lanes; ++lane) {
        const std::size_t from = std::min(lane, rays.size() - 1);
        const SegmentedRay<float>& ray = rays[from];
        for (int axis = 0; axis < 3; ++axis) {
            job.entry[axis][lane] = ray.entry[axis];
            job.step[axis][lane] = ray.step[axis];
        }
        job.segmentMm[lane] = ray.segmentMm;
        job.tail[lane] = ray.tail;
        job.count[lane] = lane < rays.size() ? ray.count : 0;
        out.mmAtEntry[lane] = mmAtEntry[from];
        if (lane < rays.size()) {
            samples[lane] = {next, 0};
            out.out[lane] = reinterpret_cast<float*>(next);
            next += 2 * ray.count;
        }
    }
    march_(scene_, job, out);
    for (std::size_t lane = 0; lane < rays.size(); ++lane)
        samples[lane] = {samples[lane].data(), static_cast<std::size_t>(out.written[lane])};
    return job.waiting == 0;
}

} // namespace tessera

// render/plan/frame_plan.cpp: see frame_plan.h.
#include "render/plan/frame_plan.h"

#include "render/plan/choose_integrator.h"

#include <algorithm>
#include <atomic>

namespace tessera {
namespace {

/// Invisible difference of a segment's colour.
constexpr double kAttenuationMatters = 1.0 / 255;

} // namespace

std::uint64_t PlanRevisions::next() {
    static std::atomic<std::uint64_t> last{0};
    return ++last;
}

Layers& Layers::operator=(Layers&& other) noexcept {
    for (std::size_t i = 0; i < std::min(all_.size(), other.all_.size()); ++i)
        *all_[i] = std::move(*other.all_[i]);
    for (std::size_t i = all_.size(); i < other.all_.size(); ++i)
        all_.push_back(std::move(other.all_[i]));
    return *this;
}

Strides FramePlan::strides() const {
    Strides strides;
    strides.sampling = view.quality.sampling;
    strides.segmentVoxels = view.quality.stepVoxels;
    if (layer().mixed())
        strides.map = &layer().levels;
    else
        strides.uniformSegments = 1 << mostStride(layer().selection, view.quality);
    return strides;
}

Integrator FramePlan::preintegration() const {
    const double change =
        view.quality.stepVoxels * typicalChangePerVoxel(layer().statistics, layer().table, info());
    const double length = view.quality.stepVoxels * typicalVoxelMm(info());
    return mayTake == Integrator::preintegrated2d &&
                   attenuationDifference(layer().table, change, length) > kAttenuationMatters
               ? Integrator::preintegrated2d
               : Integrator::preintegrated;
}

Integrator FramePlan::automaticIntegrator() const {
    return mayTake == Integrator::midpoint ||
                   !isSharp(layer().statistics, layer().table, info(), view.quality.stepVoxels)
               ? Integrator::midpoint
               : preintegration();
}

std::vector<Integrator> FramePlan::integratorsToTry() const {
    if (layer().reduces())
        return {Integrator::midpoint};
    if (view.quality.integrator != Integrator::automatic || mayTake == Integrator::midpoint ||
        isSmooth(layer().statistics, layer().table, info(), view.quality.stepVoxels))
        return {layer().optics.integrator};
    return {Integrator::midpoint, preintegration()};
}

std::size_t FramePlan::gpuTableBytes(std::size_t entries) const {
    return tableGpuBytes(entries, view.quality.integrator == Integrator::automatic ? mayTake
                                                                                   : view.quality.integrator);
}

} // namespace tessera

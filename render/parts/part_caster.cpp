// render/parts/part_caster.cpp: see part_caster.h.
#include "render/parts/part_caster.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <functional>
#include <string_view>
#include <utility>

namespace tessera {
namespace {

std::uint64_t numberOf(std::span<const std::byte> data, std::uint64_t before) {
    const std::string_view text(reinterpret_cast<const char*>(data.data()), data.size());
    return before * 0x9e3779b97f4a7c15u + std::hash<std::string_view>{}(text);
}

/// Of all that processes must agree upon before they draw rays.
std::uint64_t numberOf(const Rays& rays, const CutUnit& unit, const FramePlan& plan) {
    const RayFrame<double>& frame = rays.frame;
    const glm::dvec3 seen[] = {frame.centre, frame.right, frame.up, frame.toCentre, frame.extent};
    const double numbers[] = {frame.imageSize.x,
                              frame.imageSize.y,
                              unit.segmentVoxels,
                              static_cast<double>(unit.segments),
                              static_cast<double>(rays.size().x),
                              static_cast<double>(rays.size().y),
                              static_cast<double>(frame.phased),
                              static_cast<double>(plan.layer().optics.integrator)};
    std::uint64_t number = numberOf(std::as_bytes(std::span(seen)), 0);
    number = numberOf(std::as_bytes(std::span(numbers)), number);
    number = numberOf(std::as_bytes(rays.places), number);
    return numberOf(std::as_bytes(std::span(plan.layer().selection.levels)), number);
}

} // namespace

PartCaster::PartCaster(std::unique_ptr<RayCaster> volume, const FramePlan& plan, int threads)
    : volume_(std::move(volume)), plan_(plan), threads_(threads) {
    TESSERA_CHECK(plan.shared && !plan.layer().reduces() && !plan.fused);
}

void PartCaster::begin(const Rays& rays) {
    rays_ = rays;
    composite_.reset();
    const SharedVolume& shared = *plan_.shared;
    const Strides& strides = rays.strides;
    const CutUnit unit{strides.map ? 1 << strides.map->mostStride : strides.uniformSegments,
                       rays.frame.segmentVoxels};
    if (!shared.group.agree(numberOf(rays, unit, plan_)))
        throw InputError(
            "--ranks: expected processes that plan one picture alike, found different plans; give all "
            "the same files, options and budgets");
    segments_.resize(rayCount(rays.size()));
    constexpr std::size_t kStrip = 1024;
    parallelFor((segments_.size() + kStrip - 1) / kStrip, threads_, [&](std::size_t strip) {
        for (std::size_t ray = strip * kStrip; ray < std::min(segments_.size(), (strip + 1) * kStrip);
             ++ray) {
            const RayLine<double> line = pixelLine(rays.frame, glm::dvec2(rays.placeOf(ray)));
            double from = 0, to = 0;
            const bool meets =
                drawnPartOf(rays.frame, line, from, to); // as floats it may where this does not
            segments_[ray] = shared.parts.segments(shared.mine(), rays.frame, line, meets ? from : 0, unit);
        }
    });
    Rays mine = rays;
    mine.segments = segments_;
    volume_->begin(mine);
}

Image PartCaster::image() const {
    if (!composite_) {
        composite_ = volume_->image();
        plan_.shared->group.composite(composite_->pixels, composite_->size,
                                      plan_.shared->parts.order(rays_.frame));
    }
    return *composite_;
}

} // namespace tessera

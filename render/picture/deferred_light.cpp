// render/picture/deferred_light.cpp: see deferred_light.h.
#include "render/picture/deferred_light.h"

#include "render/backends/mirror/mirror_surfaces.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr int kColumns = 8; // of an array of ways: those of a packet follow one another

std::unique_ptr<SurfaceTracer> tracerOf(const RayCaster& caster, const FramePlan& p) {
    auto tracer = caster.surfaceTracer(SurfaceLight::kSegmentVoxels);
    return tracer ? std::move(tracer) : std::make_unique<MirrorTracer>(p, SurfaceLight::kSegmentVoxels);
}

} // namespace

DeferredLight::DeferredLight(const FramePlan& plan, int threads, bool exact,
                             const std::optional<PictureTile>& part)
    : plan_(plan) {
    if (plan.view.lighting.surfaceOcclusion)
        occlusion_.emplace(plan, threads, exact, part);
    if (plan.view.reflects)
        reflections_.emplace(plan, threads, exact);
}

PictureTile DeferredLight::around(const PictureTile& tile, const FramePlan& plan) {
    return plan.view.lighting.surfaceOcclusion
               ? tile.with(SurfaceLight::margin(*plan.view.lighting.surfaceOcclusion), plan.view.imageSize)
               : tile;
}

void DeferredLight::lookAround(const RayCaster& caster, Progress& progress) {
    progress.stage("looking around from surfaces");
    occlusion_->look(caster.hits(), *tracerOf(caster, plan_), progress.shares());
    progress.stage("drawing");
}

Image DeferredLight::added(RayCaster& caster, Engine& engine, std::span<const glm::vec2> places,
                           const glm::ivec2& size, const Slicing& slicing, Work& work) const {
    const std::vector<SurfaceHit> hits = caster.hits();
    std::optional<Image> darkened;
    if (occlusion_)
        darkened = occlusion_->added(hits, caster.meshAmbient(), places, size, *tracerOf(caster, plan_));
    if (!reflections_)
        return std::move(*darkened);
    Slicing ofWays = slicing;
    ofWays.progress = {};
    Rays rays = raysOf(plan_);
    rays.frame.cuts = {};
    // In arrays of no more rays than are planned for.
    const std::size_t most =
        std::max(rayCount(plan_.view.drawnSize()), kLeastPlacedRays) / kColumns * kColumns;
    std::vector<LightWay> array;
    const auto draw = [&](std::span<const LightWay> ways, std::span<glm::vec4> colours,
                          std::span<SurfaceHit> met) {
        for (std::size_t from = 0; from < ways.size(); from += most) {
            const auto now = ways.subspan(from, std::min(most, ways.size() - from));
            rays.arraySize = {kColumns, (static_cast<int>(now.size()) + kColumns - 1) / kColumns};
            array.assign(now.begin(), now.end());
            array.resize(rayCount(rays.arraySize)); // the remainder meets nothing
            rays.ways = array;
            caster.begin(rays);
            drawToTheEnd(caster, engine, plan_, ofWays, work);
            const Image image = caster.image();
            std::copy_n(image.pixels.begin(), now.size(),
                        colours.begin() + static_cast<std::ptrdiff_t>(from));
            const std::vector<SurfaceHit> first = caster.hits();
            std::copy_n(first.begin(), now.size(), met.begin() + static_cast<std::ptrdiff_t>(from));
        }
    };
    Image mirrored = reflections_->added(hits, places, size, draw);
    if (darkened)
        std::transform(mirrored.pixels.begin(), mirrored.pixels.end(), darkened->pixels.begin(),
                       mirrored.pixels.begin(), std::plus<>());
    return mirrored;
}

void DeferredLight::addReport(RenderResult& result) const {
    const auto surfaces = result.surfaceLight;
    const auto ways = result.reflections;
    report(result);
    if (surfaces && result.surfaceLight) {
        result.surfaceLight->places += surfaces->places;
        result.surfaceLight->alone += surfaces->alone;
        result.surfaceLight->seconds += surfaces->seconds;
    }
    if (ways && result.reflections) {
        for (std::size_t order = 0; order < ways->ways.size(); ++order)
            result.reflections->ways[order] += ways->ways[order];
        result.reflections->met += ways->met;
        result.reflections->near += ways->near;
        result.reflections->seconds += ways->seconds;
    }
}

void DeferredLight::report(RenderResult& result) const {
    if (occlusion_)
        result.surfaceLight = occlusion_->report();
    if (reflections_)
        result.reflections = reflections_->report();
}

} // namespace tessera

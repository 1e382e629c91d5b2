// render/geometry/mesh_caster.cpp: see mesh_caster.h.
#include "render/geometry/mesh_caster.h"

#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/contract/leaves.h"

#include <algorithm>
#include <atomic>
#include <utility>

namespace tessera {

MeshCaster::MeshCaster(std::unique_ptr<RayCaster> volume, const FramePlan& plan, bool hits, bool shadows,
                       int threads)
    : volume_(std::move(volume)), plan_(plan), tellsHits_(hits), hasShadows_(shadows), threads_(threads) {
    TESSERA_CHECK(!plan.view.meshes.empty() && !plan.layer().reduces());
}

template <typename Visit> void MeshCaster::forEachRay(const Visit& visit) const {
    constexpr std::size_t kStrip = 1024;
    parallelFor((ends_.size() + kStrip - 1) / kStrip, threads_, [&](std::size_t strip) {
        for (std::size_t ray = strip * kStrip; ray < std::min(ends_.size(), (strip + 1) * kStrip); ++ray)
            visit(ray);
    });
}

RayLine<double> MeshCaster::lineOf(std::size_t ray) const {
    const auto width = static_cast<std::size_t>(rays_.size().x);
    return pixelLine(rays_.frame, rays_.places.empty() ? glm::dvec2(static_cast<double>(ray % width),
                                                                    static_cast<double>(ray / width)) +
                                                             0.5
                                                       : glm::dvec2(rays_.places[ray]));
}

void MeshCaster::endNext(std::size_t ray, const MeshRays& meshes, const MeshRays::Order& after) {
    const std::optional<MeshRays::Surface> surface = meshes.next(lineOf(ray), after);
    ends_[ray] = {after.t, surface ? surface->at.t : MeshRays::kFar};
    fronts_[ray] = surface ? Front{surface->at, surface->colour, true, !(surface->colour.a < 1)} : Front();
    if (isFirst_ && tellsHits_ && surface)
        keepHit(ray, *surface);
}

/// Of the first mesh; its weight follows.
void MeshCaster::keepHit(std::size_t ray, const MeshRays::Surface& surface) {
    const RayLine<double> line = lineOf(ray);
    hits_[ray] = {glm::vec3(line.base + surface.at.t * line.direction), 0, glm::vec3(surface.normal),
                  static_cast<int>(plan_.layer().optics.surfaces.size()) + 1 + surface.at.mesh};
    meshAmbient_[ray] = surface.ambient;
}

void MeshCaster::begin(const Rays& rays) {
    rays_ = rays;
    picture_ = Image(rays.size());
    hits_.assign(tellsHits_ ? rayCount(rays.size()) : 0, SurfaceHit());
    meshAmbient_.assign(hits_.size(), glm::vec3(0));
    ends_.assign(rayCount(rays.size()), RayPart());
    fronts_.assign(ends_.size(), Front());
    isFirst_ = true;
    isFinished_ = false;
    placeLight();
    const MeshRays meshes(plan_, rays_.frame, light_.get());
    forEachRay([&](std::size_t ray) { endNext(ray, meshes, MeshRays::Order()); });
    beginRound();
}

/// Maps are those of the bricks, the function and the camera at hand: lights may be fixed to the camera.
void MeshCaster::placeLight() {
    if (!hasShadows_ || !MeshLight::isNeeded(plan_))
        return;
    const PlanRevisions& now = plan_.revisions;
    if (light_ && lightOf_.function == now.function && lightOf_.levels == now.levels &&
        lightFrom_ == plan_.view.camera)
        return;
    light_.reset(); // never two at once
    light_ = std::make_unique<MeshLight>(plan_, threads_);
    lightOf_ = now;
    lightFrom_ = plan_.view.camera;
}

void MeshCaster::beginRound() {
    Rays round = rays_;
    round.frame.ends = ends_;
    volume_->begin(round);
}

bool MeshCaster::takeRound() {
    const Image volume = volume_->image();
    const bool asks = isFirst_ && tellsHits_ && !plan_.layer().optics.surfaces.empty();
    const std::vector<SurfaceHit> met = asks ? volume_->hits() : std::vector<SurfaceHit>();
    const bool isFirst = isFirst_;
    isFirst_ = false;
    const MeshRays meshes(plan_, rays_.frame, light_.get());
    const float enough = 1 - plan_.layer().optics.termination;
    std::atomic<bool> goesOn = false;
    forEachRay([&](std::size_t ray) {
        if (ends_[ray].from > ends_[ray].to)
            return;
        glm::vec4& pixel = picture_.pixels[ray];
        pixel += (1 - pixel.a) * volume.pixels[ray];
        if (isFirst && tellsHits_) {
            hits_[ray].weight = 1 - pixel.a;
            if (!met.empty() && met[ray].surface != 0)
                hits_[ray] = met[ray];
        }
        const Front front = fronts_[ray];
        if (front.isThere) {
            glm::vec3 sum(pixel);
            leaf::compositeBehind(sum, pixel.a, glm::vec3(front.colour), front.colour.a);
            pixel = {sum, pixel.a};
        }
        if (front.isLast || !(pixel.a < enough)) {
            ends_[ray] = {1, 0};
            return;
        }
        endNext(ray, meshes, front.at);
        goesOn = true;
    });
    return goesOn;
}

bool MeshCaster::draw(const Slicing& slicing, Clock::time_point deadline, Work& work) {
    Slicing silent = slicing;
    silent.progress = {}; // only the first interval is a known share of the work
    while (!isFinished_) {
        if (!volume_->draw(isFirst_ ? slicing : silent, deadline, work))
            return false;
        if (volume_->waiting() > 0)
            return true;
        if (!takeRound()) {
            isFinished_ = true;
            break;
        }
        beginRound();
        if (Clock::now() >= deadline)
            return false;
    }
    return true;
}

std::unique_ptr<RayCaster> casterWithMeshes(Engine& engine, const FramePlan& plan,
                                            const CasterOptions& options, MemoryBudget& gpu, int threads,
                                            bool shadows) {
    if (plan.view.meshes.empty())
        return engine.caster(options, gpu);
    CasterOptions ofVolume = options;
    ofVolume.hits = options.hits && !plan.layer().optics.surfaces.empty();
    std::unique_ptr<RayCaster> volume = engine.caster(ofVolume, gpu);
    return std::make_unique<MeshCaster>(std::move(volume), plan, options.hits, shadows, threads);
}

std::size_t meshBytesPerPixel(const Scene& scene) {
    return drawsMeshes(scene) ? MeshCaster::bytesPerRay() : 0;
}

} // namespace tessera

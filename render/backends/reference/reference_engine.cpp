// render/backends/reference/reference_engine.cpp: see reference_engine.h.
#include "render/backends/reference/reference_engine.h"

#include "core/base/error.h"
#include "render/backends/reference/reference.h"
#include "render/backends/reference/surface_rays.h"
#include "render/plan/fusion.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

namespace tessera {
namespace {

constexpr std::size_t kRaysAtATime = 512, kLitRaysAtATime = 64; // with a deadline
constexpr std::size_t kRaysTogether = 4096;                     // else
constexpr std::uint32_t kOwnNumbers = 0x5eed;                   // added to a scene's seed

class ReferenceCaster : public RayCaster {
  public:
    ReferenceCaster(const FramePlan& scene, bool tellsHits, int threads)
        : scene_(scene), tellsHits_(tellsHits), threads_(threads) {}

    /// Rays are the view's own, in double; strides are ignored.
    void begin(const Rays& rays) override {
        check(rays);
        TESSERA_CHECK(glm::ivec2(rays.frame.imageSize) == scene_.view.imageSize);
        rays_ = rays;
        picture_ = Image(rays.size());
        hits_.clear();
        done_ = 0;
    }

    bool draw(const Slicing& slicing, Clock::time_point deadline, Work&) override {
        const bool whole = deadline == Clock::time_point::max();
        ReferenceInput input = this->input();
        const std::optional<PathScene> paths = pathsOf(input);
        std::vector<PathStart> starts;
        const std::size_t all = picture_.pixels.size(), most = whole ? kRaysTogether
                                                               : lightChannels(scene_.view.lighting) > 0
                                                                   ? kLitRaysAtATime
                                                                   : kRaysAtATime;
        std::optional<ReferenceSurfaces> surfaces;
        if (tellsHits_)
            surfaces.emplace(input);
        while (done_ < all) {
            const std::size_t count = std::min(all - done_, most);
            if (whole && slicing.progress)
                input.progress = [&](double share) {
                    slicing.progress((static_cast<double>(done_) + share * static_cast<double>(count)) /
                                     static_cast<double>(all));
                };
            const std::vector<ReferenceRay> rays = raysFrom(done_, count);
            if (paths) {
                starts.clear();
                for (std::size_t n = done_; n < done_ + count; ++n)
                    starts.push_back({rays_.placeOf(n), rays_.numberOf(n)});
                input.paths = &*paths;
                input.starts = starts;
            }
            const auto values = renderReference(input, rays, threads_);
            std::transform(values.begin(), values.end(),
                           picture_.pixels.begin() + static_cast<std::ptrdiff_t>(done_),
                           [](const glm::dvec4& v) { return glm::vec4(v); });
            if (surfaces) {
                std::vector<double> at;
                auto hits = surfaces->firstHits(rays, threads_, at);
                if (surfaces->showsVolume() || input.reflects)
                    weigh(rays, at, hits);
                hits_.insert(hits_.end(), hits.begin(), hits.end());
            }
            done_ += count;
            if (Clock::now() >= deadline)
                break;
        }
        return done_ == all;
    }

    Image image() const override { return picture_; }
    std::vector<SurfaceHit> hits() const override { return hits_; }
    std::unique_ptr<SurfaceTracer> surfaceTracer(double) const override {
        return std::make_unique<ReferenceSurfaces>(input());
    }

  private:
    /// Light that the volume before surfaces leaves.
    /// @param at  their parameters along the rays
    void weigh(std::vector<ReferenceRay> rays, const std::vector<double>& at,
               std::vector<SurfaceHit>& hits) const {
        ReferenceInput input = this->input();
        input.shading.on = false;
        input.lighting = {};
        input.paths = nullptr;
        input.starts = {};
        for (std::size_t n = 0; n < rays.size(); ++n) {
            constexpr double kBefore = 1e-6; // voxels; the surface is not before itself
            rays[n].tMax = hits[n].surface ? at[n] - kBefore / glm::length(rays[n].direction) : rays[n].tMin;
        }
        const std::vector<glm::dvec4> before = renderReference(input, rays, threads_);
        for (std::size_t n = 0; n < hits.size(); ++n)
            hits[n].weight = static_cast<float>(1 - before[n].a);
    }
    /// The light of rays that ask for paths: where the mean of these is an integral, that.
    std::optional<PathScene> pathsOf(ReferenceInput& input) const {
        if (!rays_.paths)
            return {};
        if (input.lighting.transport->response == TransportResponse::contract) {
            input.shading.on = true;
            input.lighting = scene_.view.pathLighting;
            input.lighting.transport.reset();
            return {};
        }
        PathScene paths = pathSceneOf(scene_, nullptr);
        if (!paths.isovalues.empty())
            throw badFile("--engine", "native or mirror for paths of light among isosurfaces", "reference");
        paths.seed += kOwnNumbers;
        return paths;
    }
    glm::dvec2 placeOf(std::size_t n) const {
        const std::size_t width = static_cast<std::size_t>(rays_.frame.imageSize.x);
        return rays_.places.empty()
                   ? glm::dvec2(static_cast<double>(n % width), static_cast<double>(n / width)) + 0.5
                   : glm::dvec2(rays_.places[n]);
    }
    std::vector<ReferenceRay> raysFrom(std::size_t first, std::size_t count) const {
        if (!rays_.ways.empty()) {
            std::vector<ReferenceRay> rays;
            for (const LightWay& way : rays_.ways.subspan(first, count))
                rays.push_back({way.from, way.direction / way.mmPerVoxel, 0, way.voxels * way.mmPerVoxel});
            return rays;
        }
        std::vector<glm::vec2> places(count); // exact: whole pixels and a half, or given ones
        for (std::size_t n = 0; n < count; ++n)
            places[n] = glm::vec2(placeOf(first + n));
        const ViewState& view = scene_.view;
        std::vector<ReferenceRay> rays =
            referenceRays(view.camera, scene_.rayVoxels(), view.imageSize, places);
        for (std::size_t n = 0; n < count && !rays_.frame.ends.empty(); ++n)
            end(first + n, rays[n]);
        return rays;
    }
    /// Ends a ray as the frame has it: in mm from where the reference's own ray begins.
    void end(std::size_t n, ReferenceRay& ray) const {
        const RayLine<double> line = pixelLine(rays_.frame, placeOf(n));
        const double squared = glm::dot(ray.direction, ray.direction);
        const auto along = [&](double t) {
            return glm::dot(line.base - ray.base + t * line.direction, ray.direction) / squared;
        };
        const RayPart& part = rays_.frame.ends[n];
        ray.tMin = std::max(ray.tMin, along(part.from));
        ray.tMax = along(part.to);
    }
    static ReferenceInput inputOf(const FramePlan& plan) {
        const Layer& volume = plan.layer();
        ReferenceInput input;
        input.cache = volume.cache.get();
        input.info = &plan.info();
        input.function = &volume.function;
        input.shading = plan.view.shading;
        input.statistics = &volume.statistics;
        input.surfaces = plan.view.surfaces;
        input.reflects = plan.view.reflects && !plan.view.lighting.surfaceOcclusion;
        input.lighting = plan.view.lighting;
        input.camera = plan.view.camera;
        input.reduction = volume.optics.reduction;
        input.look = volume.look;
        input.thinness = volume.addsUp ? double{Exposure::kThin} : 1;
        const DrawnPart& part = plan.fused ? plan.fused->part : plan.view.part;
        input.slabs = part.slabs;
        input.flat = part.flat;
        input.cuts = part.cuts.get();
        input.labels = volume.labelBricks.get();
        input.meshes = plan.view.meshes;
        if (plan.fused) {
            input.fused = &*plan.fused;
            input.fromLattice = plan.fused->fromLattice;
            input.ownCuts = &plan.fused->cuts.exact;
            for (const auto& volume : plan.further) {
                ReferenceInput& further = input.further.emplace_back(inputOf(volume->plan));
                further.fromLattice = volume->fromLattice;
                further.ownCuts = &volume->cuts.exact;
            }
        }
        return input;
    }
    ReferenceInput input() const { return inputOf(scene_); }

    const FramePlan& scene_;
    bool tellsHits_;
    int threads_;
    Rays rays_;
    std::vector<SurfaceHit> hits_;
    Image picture_;
    std::size_t done_ = 0; // rays
};

} // namespace

void ReferenceEngine::open(const FramePlan& plan, std::size_t) {
    scene_ = &plan;
}

std::unique_ptr<RayCaster> ReferenceEngine::caster(const CasterOptions& options, MemoryBudget&) {
    return std::make_unique<ReferenceCaster>(*scene_, options.hits, threads_);
}

EngineTraits referenceTraits() {
    EngineTraits traits;
    traits.kind = EngineKind::reference;
    traits.name = "reference";
    traits.exact = traits.singleRays = true;
    traits.fuses = traits.followsPaths = true;
    traits.make = [](const EngineInput& input) -> std::unique_ptr<Engine> {
        return std::make_unique<ReferenceEngine>(input.threads);
    };
    return traits;
}

} // namespace tessera

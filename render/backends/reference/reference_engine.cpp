// render/backends/reference/reference_engine.cpp: see reference_engine.h.
#include "render/backends/reference/reference_engine.h"

#include "core/base/error.h"
#include "render/backends/reference/reference.h"
#include "render/backends/reference/surface_rays.h"
#include "render/plan/fusion.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace tessera {
namespace {

constexpr std::size_t kRaysAtATime = 512, kLitRaysAtATime = 64; // per call with a deadline

class ReferenceCaster : public RayCaster {
  public:
    ReferenceCaster(const FramePlan& scene, bool tellsHits, int threads)
        : scene_(scene), tellsHits_(tellsHits), threads_(threads) {}

    /// Rays are the view's own, in double; strides are ignored.
    void begin(const Rays& rays) override {
        check(rays);
        const ViewState& view = scene_.view;
        TESSERA_CHECK(glm::ivec2(rays.frame.imageSize) == view.imageSize);
        rays_ = rays.places.empty()
                    ? referenceRays(view.camera, scene_.rayVoxels(), view.imageSize)
                    : referenceRays(view.camera, scene_.rayVoxels(), view.imageSize, rays.places);
        for (std::size_t n = 0; n < rays.frame.ends.size(); ++n)
            end(rays, n);
        picture_ = Image(rays.size());
        done_ = 0;
    }

    bool draw(const Slicing& slicing, Clock::time_point deadline, Work&) override {
        const bool whole = deadline == Clock::time_point::max();
        ReferenceInput input = this->input();
        input.progress = whole ? slicing.progress : ShareDone{};
        const std::size_t most = lightChannels(scene_.view.lighting) > 0 ? kLitRaysAtATime : kRaysAtATime;
        do {
            const std::size_t left = picture_.pixels.size() - done_;
            const std::size_t count = whole ? left : std::min(left, most);
            const auto first = rays_.begin() + static_cast<std::ptrdiff_t>(done_);
            const auto last = first + static_cast<std::ptrdiff_t>(count);
            const auto values = whole && done_ == 0 ? renderReference(input, rays_, threads_)
                                                    : renderReference(input, {first, last}, threads_);
            std::transform(values.begin(), values.end(),
                           picture_.pixels.begin() + static_cast<std::ptrdiff_t>(done_),
                           [](const glm::dvec4& v) { return glm::vec4(v); });
            done_ += count;
        } while (done_ < picture_.pixels.size() && Clock::now() < deadline);
        if (done_ < picture_.pixels.size())
            return false;
        if (tellsHits_)
            hits_ = ReferenceSurfaces(input).firstHits(rays_, threads_);
        rays_ = {};
        return true;
    }

    Image image() const override { return picture_; }
    std::vector<SurfaceHit> hits() const override { return hits_; }
    std::unique_ptr<SurfaceTracer> surfaceTracer(double) const override {
        return std::make_unique<ReferenceSurfaces>(input());
    }

  private:
    /// Ends a ray as the frame has it: in mm from where the reference's own ray begins.
    void end(const Rays& rays, std::size_t n) {
        const std::size_t width = static_cast<std::size_t>(rays.frame.imageSize.x);
        const glm::dvec2 place =
            rays.places.empty()
                ? glm::dvec2(static_cast<double>(n % width), static_cast<double>(n / width)) + 0.5
                : glm::dvec2(rays.places[n]);
        const RayLine<double> line = pixelLine(rays.frame, place);
        ReferenceRay& ray = rays_[n];
        const double squared = glm::dot(ray.direction, ray.direction);
        const auto along = [&](double t) {
            return glm::dot(line.base - ray.base + t * line.direction, ray.direction) / squared;
        };
        const RayPart& part = rays.frame.ends[n];
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
        input.lighting = plan.view.lighting;
        input.camera = plan.view.camera;
        input.reduction = volume.optics.reduction;
        input.look = volume.look;
        const DrawnPart& part = plan.fused ? plan.fused->part : plan.view.part;
        input.slabs = part.slabs;
        input.flat = part.flat;
        input.cuts = part.cuts.get();
        input.labels = volume.labelBricks.get();
        input.meshes = plan.view.meshes;
        if (plan.fused) {
            input.fused = &*plan.fused;
            input.fromLattice = plan.fused->fromLattice;
            for (const auto& further : plan.further)
                input.further.emplace_back(inputOf(further->plan)).fromLattice = further->fromLattice;
        }
        return input;
    }
    ReferenceInput input() const { return inputOf(scene_); }

    const FramePlan& scene_;
    bool tellsHits_;
    int threads_;
    std::vector<ReferenceRay> rays_;
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
    // its rays, their colours, and the picture made from them
    traits.bytesPerPixel =
        std::max(kPictureBytesPerPixel, sizeof(ReferenceRay) + sizeof(glm::dvec4) + sizeof(glm::vec4));
    traits.fuses = true;
    traits.make = [](const EngineInput& input) -> std::unique_ptr<Engine> {
        return std::make_unique<ReferenceEngine>(input.threads);
    };
    return traits;
}

} // namespace tessera

// render/backends/mirror/mirror_engine.cpp: see mirror_engine.h.
#include "render/backends/mirror/mirror_engine.h"

#include "core/base/error.h"
#include "render/backends/mirror/mirror.h"
#include "render/light/scene_light.h"
#include "render/plan/visibility_rays.h"

#include <algorithm>

namespace tessera {
namespace {

constexpr std::size_t kRaysAtATime = 4096; // per task with a deadline

class MirrorCaster : public RayCaster {
  public:
    MirrorCaster(const FramePlan& scene, const CasterOptions& options, int threads, MemoryBudget& budget)
        : scene_(scene), hits_(options.hits), threads_(threads), budget_(budget) {}

    void begin(const Rays& rays) override {
        check(rays);
        rays_ = rays;
        picture_ = Image(rays.size());
        done_ = 0;
        cuts_.reset();
        if (rays.frame.cuts)
            cuts_ = cutRays(rays.frame, rays.places, threads_);
        if (lightChannels(scene_.view.lighting) > 0)
            lightBricks();
    }

    bool draw(const Slicing& slicing, Clock::time_point deadline, Work& work) override {
        const bool whole = deadline == Clock::time_point::max();
        MirrorInput input = this->input();
        input.progress = whole ? slicing.progress : ShareDone{};
        const auto all = frameRays(cast<float>(rays_.frame), rays_.places, rays_.arraySize.x);
        do {
            const std::size_t left = picture_.pixels.size() - done_;
            const std::size_t count = whole ? left : std::min(left, kRaysAtATime);
            input.firstRay = done_;
            const auto colours = mirrorRays<float>(
                input, count, [&](std::size_t i) { return all(done_ + i); }, threads_, work);
            std::copy(colours.begin(), colours.end(),
                      picture_.pixels.begin() + static_cast<std::ptrdiff_t>(done_));
            done_ += count;
        } while (done_ < picture_.pixels.size() && Clock::now() < deadline);
        return done_ == picture_.pixels.size();
    }

    Image image() const override { return picture_; }
    std::vector<SurfaceHit> hits() const override {
        if (!hits_)
            return {};
        return mirrorHits<float>(input(), picture_.pixels.size(),
                                 frameRays(cast<float>(rays_.frame), rays_.places, rays_.arraySize.x),
                                 threads_);
    }

  private:
    /// Lights bricks for the current scene, unless they are lit.
    void lightBricks() {
        const std::vector<std::uint8_t>& levels = scene_.layer().selection.levels;
        if (light_ && litLevels_ == levels && litCamera_ == scene_.view.camera &&
            litFunction_ == scene_.revisions.function)
            return;
        light_.reset();
        SceneLight light(scene_, threads_);
        light_.emplace(light, scene_, budget_);
        litLevels_ = levels;
        litCamera_ = scene_.view.camera;
        litFunction_ = scene_.revisions.function;
    }
    MirrorInput input() const {
        MirrorInput input = mirrorInput(scene_, scene_.view.quality.skipping);
        input.strides = rays_.strides;
        input.light = light_ ? &*light_ : nullptr;
        input.cuts = cuts_ ? &*cuts_ : nullptr;
        input.segmentVoxels = rays_.frame.segmentVoxels;
        return input;
    }

    const FramePlan& scene_;
    bool hits_;
    int threads_;
    MemoryBudget& budget_;
    std::optional<StoredLight> light_;
    std::vector<std::uint8_t> litLevels_; // at the time of light_
    Camera litCamera_;
    std::uint64_t litFunction_ = 0;
    Rays rays_;
    std::optional<CutRays> cuts_;
    Image picture_;
    std::size_t done_ = 0; // rays
};

class MirrorCounter : public VisibilityCounter {
  public:
    MirrorCounter(const FramePlan& scene, int threads) : scene_(scene), threads_(threads) {}
    void begin() override {}
    bool count(const Slicing&, RayCaster::Clock::time_point) override {
        const VisibilityRays rays =
            visibilityRays(scene_.view.camera, scene_.info(), scene_.view.imageSize, scene_.strides());
        MirrorInput input = mirrorInput(scene_, false);
        input.strides = rays.strides;
        seen_ = mirrorSeen(input, rayCount(glm::ivec2(rays.frame.imageSize)),
                           frameRays(cast<float>(rays.frame)), threads_);
        return true;
    }
    std::vector<SeenBrick> seen() const override { return seen_; }

  private:
    const FramePlan& scene_;
    int threads_;
    std::vector<SeenBrick> seen_;
};

} // namespace

void MirrorEngine::open(std::span<const FramePlan* const> plans, std::size_t) {
    TESSERA_CHECK(plans.size() == 1);
    scene_ = plans.front();
}

std::unique_ptr<RayCaster> MirrorEngine::caster(const CasterOptions& options, MemoryBudget& gpu) {
    return std::make_unique<MirrorCaster>(*scene_, options, threads_, gpu);
}

std::unique_ptr<VisibilityCounter> MirrorEngine::counter(MemoryBudget&) {
    return std::make_unique<MirrorCounter>(*scene_, threads_);
}

EngineTraits mirrorTraits() {
    EngineTraits traits;
    traits.kind = EngineKind::mirror;
    traits.name = "mirror";
    traits.singleRays = true;
    traits.make = [](const EngineInput& input) -> std::unique_ptr<Engine> {
        return std::make_unique<MirrorEngine>(input.threads);
    };
    return traits;
}

} // namespace tessera

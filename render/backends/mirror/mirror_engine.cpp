// render/backends/mirror/mirror_engine.cpp: see mirror_engine.h.
#include "render/backends/mirror/mirror_engine.h"

#include "core/base/error.h"
#include "render/backends/mirror/mirror.h"
#include "render/light/scene_light.h"
#include "render/plan/fusion.h"
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
        beginnings_.assign(rays.beginnings ? picture_.pixels.size() : 0, PathBeginning());
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
        const auto all = source();
        do {
            const std::size_t left = picture_.pixels.size() - done_;
            const std::size_t count = whole ? left : std::min(left, kRaysAtATime);
            input.firstRay = done_;
            const auto from = [&](std::size_t i) { return all(done_ + i); };
            auto colours = mirrorRays<float>(input, count, from, threads_, work);
            if (rays_.paths)
                mirrorPaths(
                    input, pathSceneOf(scene_, input.occupancy), from,
                    [&](std::size_t i) {
                        return PathStart{rays_.placeOf(done_ + i), rays_.numberOf(done_ + i)};
                    },
                    colours, std::span(beginnings_).subspan(rays_.beginnings ? done_ : 0), threads_, work);
            std::copy(colours.begin(), colours.end(),
                      picture_.pixels.begin() + static_cast<std::ptrdiff_t>(done_));
            done_ += count;
        } while (done_ < picture_.pixels.size() && Clock::now() < deadline);
        return done_ == picture_.pixels.size();
    }

    Image image() const override { return picture_; }
    std::span<const PathBeginning> beginnings() const override { return beginnings_; }
    std::vector<SurfaceHit> hits() const override {
        if (!hits_)
            return {};
        return mirrorHits<float>(input(), picture_.pixels.size(), source(), threads_);
    }

  private:
    /// A volume's light, and what it was made for.
    struct Lit {
        std::optional<StoredLight> light;
        std::vector<std::uint8_t> levels;
        Camera camera;
        std::uint64_t function = 0;
    };
    /// Lights the bricks of all volumes, unless they are lit. Each shades the others.
    void lightBricks() {
        std::vector<const FramePlan*> plans = {&scene_};
        std::vector<MemoryBudget*> budgets = {&budget_};
        for (const auto& volume : scene_.further) {
            plans.push_back(&volume->plan);
            budgets.push_back(&volume->gpu);
        }
        const auto isLit = [](const FramePlan& plan, const Lit& lit) {
            return lit.light && lit.levels == plan.layer().selection.levels &&
                   lit.camera == plan.view.camera && lit.function == plan.revisions.function;
        };
        bool all = lit_.size() == plans.size();
        for (std::size_t n = 0; n < lit_.size(); ++n)
            all = all && isLit(*plans[n], lit_[n]);
        if (all)
            return;
        lit_.clear();
        lit_.resize(plans.size());
        std::vector<std::unique_ptr<SceneLight>> lights;
        for (const FramePlan* plan : plans)
            lights.push_back(std::make_unique<SceneLight>(*plan, threads_));
        for (const auto& light : lights)
            light->ready();
        for (const auto& light : lights) {
            std::vector<SceneLight*> others;
            for (const auto& other : lights)
                if (other != light)
                    others.push_back(other.get());
            light->shadedBy(others);
        }
        for (std::size_t n = 0; n < plans.size(); ++n) {
            lit_[n].light.emplace(*lights[n], *plans[n], *budgets[n]);
            lit_[n].levels = plans[n]->layer().selection.levels;
            lit_[n].camera = plans[n]->view.camera;
            lit_[n].function = plans[n]->revisions.function;
        }
    }
    RaySource<float> source() const {
        if (rays_.ways.empty())
            return frameRays(cast<float>(rays_.frame), rays_.places, rays_.arraySize.x);
        return [ways = rays_.ways, voxels = rays_.frame.segmentVoxels](std::size_t i) {
            return segmentedWay<float>(ways[i], voxels);
        };
    }
    MirrorInput input() const {
        MirrorInput input = mirrorInput(scene_, scene_.view.quality.skipping);
        input.strides = rays_.strides;
        for (std::size_t n = 0; n < lit_.size(); ++n)
            (n == 0 ? input : input.further[n - 1]).light = &*lit_[n].light;
        input.cuts = cuts_ ? &*cuts_ : nullptr;
        input.segmentVoxels = rays_.frame.segmentVoxels;
        input.hullSamples = rays_.frame.hullSamples();
        return input;
    }

    const FramePlan& scene_;
    bool hits_;
    int threads_;
    MemoryBudget& budget_;
    std::vector<Lit> lit_; // of all volumes, where the scene has light of voxels
    Rays rays_;
    std::optional<CutRays> cuts_;
    Image picture_;
    std::vector<PathBeginning> beginnings_;
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

void MirrorEngine::open(const FramePlan& plan, std::size_t) {
    scene_ = &plan;
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
    traits.fuses = traits.followsPaths = true;
    traits.make = [](const EngineInput& input) -> std::unique_ptr<Engine> {
        return std::make_unique<MirrorEngine>(input.threads);
    };
    return traits;
}

} // namespace tessera

// render/backends/native/native_engine.cpp: see native_engine.h.
#include "render/backends/native/native_engine.h"

#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/backends/mirror/mirror.h"
#include "render/backends/native/native_caster.h"
#include "render/backends/native/native_field.h"
#include "render/backends/native/native_shadows.h"
#include "render/plan/fusion.h"
#include "render/plan/visibility_rays.h"

#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kNumberedSamples = std::size_t{1} << 31; // the most that 32 bits number

/// As mirrorSeen(), over the engine's bricks.
class NativeCounter : public VisibilityCounter {
  public:
    NativeCounter(const FramePlan& scene, NativeEngine& engine) : scene_(scene), engine_(engine) {}
    void begin() override {
        engine_.settlePlan();
        row_ = 0;
        rays_ = visibilityRays(scene_.view.camera, scene_.info(), scene_.view.imageSize, scene_.strides());
        seen_.assign(scene_.layer().selection.levels.size(), SeenBrick());
    }
    bool count(const Slicing&, RayCaster::Clock::time_point deadline) override {
        const HostPlane& plane = engine_.settled();
        const glm::ivec2 size(rays_.frame.imageSize);
        const RayFrame<float> frame = cast<float>(rays_.frame);
        MirrorInput input; // the inputs of a ray that counts
        input.selection = &scene_.layer().selection;
        input.optics = &scene_.layer().optics;
        input.strides = rays_.strides;
        constexpr int kRowsAtATime = 8;
        while (row_ < size.y) {
            const int end = deadline == RayCaster::Clock::time_point::max()
                                ? size.y
                                : std::min(size.y, row_ + kRowsAtATime);
            parallelFor(static_cast<std::size_t>(end - row_), engine_.threads(), [&](std::size_t row) {
                NativeField field(plane, scene_.layer().mixed() ? &scene_.layer().levels : nullptr,
                                  scene_.layer().selection.finest(), scene_.layer().optics.gradient);
                field.setLabels(engine_.labelChannels(), scene_.layer().optics.labels);
                for (int x = 0; x < size.x; ++x)
                    seeAlong(segmentedRay(frame,
                                          glm::vec2(static_cast<float>(x) + 0.5f,
                                                    static_cast<float>(row_ + static_cast<int>(row)) + 0.5f)),
                             field, input, seen_);
            });
            row_ = end;
            if (RayCaster::Clock::now() >= deadline)
                break;
        }
        return row_ >= size.y;
    }
    std::vector<SeenBrick> seen() const override { return seen_; }

  private:
    const FramePlan& scene_;
    NativeEngine& engine_;
    VisibilityRays rays_;
    std::vector<SeenBrick> seen_;
    int row_ = 0;
};

} // namespace

Engine::About NativeEngine::about() const {
    About about;
    about.device = std::string("CPU, ") + native::packetTarget().name;
    about.choosesSteps = about.measures = about.followsPaths = true;
    return about;
}

TextureLimits NativeEngine::limits() const {
    TextureLimits limits;
    limits.maxExtent = 1 << 15;
    limits.pageEdge = kGhostedEdge;
    limits.readsOnce = true;
    limits.maxBytes = kNumberedSamples * 2;
    limits.indexEntryBytes = sizeof(native::PacketBrick) + 3 * sizeof(BrickEntry);
    return limits;
}

void NativeEngine::open(const FramePlan& plan, std::size_t pages) {
    close();
    scene_ = &plan;
    taken_ = scene_->revisions;
    TextureLimits limits = this->limits();
    limits.pageEdge = scene_->layer().pageEdge;
    limits.channelsBeside = scene_->channelsBeside();
    plane_ = std::make_unique<HostPlane>(scene_->info(), pages, limits, threads_, gpu_);
    std::vector<Plane*> planes{plane_.get()};
    const auto channels = [&](int count, const char* what, std::vector<std::unique_ptr<HostPlane>>& kept) {
        std::vector<Plane*> all;
        for (int n = 0; n < count; ++n)
            all.push_back(kept.emplace_back(std::make_unique<HostPlane>(scene_->info(), ValueType::u16, what,
                                                                        pages, limits, threads_, gpu_))
                              .get());
        return all;
    };
    if (const DrawnLabels* labels = scene_->layer().labels.get())
        planes.push_back(&labelPlane_.emplace(
            *labels, channels(labels->numbers().count, "labels of the bricks", labelPlanes_)));
    if (const int count = tessera::lightChannels(scene_->view.lighting); count > 0) {
        sceneLight_.emplace(*scene_, threads_);
        planes.push_back(&lightPlane_.emplace(*sceneLight_, *scene_,
                                              channels(count, "light of the bricks", lightPlanes_)));
        litBy_ = scene_->view.camera;
    }
    bricks_.emplace(scene_->info(), scene_->layer().selection, pages, limits, std::move(planes), ram_);
    for (const auto& volume : plan.further)
        further_.push_back(std::make_unique<NativeEngine>(threads_, volume->gpu, volume->ram));
}

void NativeEngine::close() {
    further_.clear();
    bricks_.reset();
    lightPlane_.reset();
    sceneLight_.reset();
    lightPlanes_.clear();
    labelPlane_.reset();
    labelPlanes_.clear();
    plane_.reset();
    scene_ = nullptr;
}

const HostPlane& NativeEngine::settled() {
    settlePlan();
    const Layer& volume = scene_->layer();
    plane_->settle(volume.mixed() ? &volume.levels : nullptr, volume.selection.finest());
    for (const auto& plane : labelPlanes_)
        plane->settle(volume.mixed() ? &volume.levels : nullptr, volume.selection.finest());
    return *plane_;
}

void NativeEngine::settlePlan() {
    const PlanRevisions before = std::exchange(taken_, scene_->revisions);
    if (before.levels != taken_.levels) {
        plane_->levelsChanged();
        for (const auto* planes : {&lightPlanes_, &labelPlanes_})
            for (const auto& plane : *planes)
                plane->levelsChanged();
        if (sceneLight_)
            sceneLight_->levelsChanged();
    }
    if (sceneLight_ && (before.function != taken_.function || before.tables != taken_.tables))
        sceneLight_->functionChanged();
}

std::optional<LightReport> NativeEngine::lightReport() const {
    if (!sceneLight_)
        return std::nullopt;
    std::size_t bytes = 0;
    for (const auto& plane : lightPlanes_)
        bytes += plane->bytes();
    return sceneLight_->report(bytes);
}

/// Takes the camera that lights are fixed to.
void NativeEngine::lookAgain() {
    if (litBy_ == scene_->view.camera)
        return;
    litBy_ = scene_->view.camera;
    sceneLight_->viewChanged();
}

/// Shadow maps are cast by packets through the bricks, where they can.
template <typename Action> void NativeEngine::withRays(const Action& action) {
    std::optional<NativeShadows> rays;
    if (NativeShadows::canCast(*scene_))
        sceneLight_->castBy(&rays.emplace(*scene_, *plane_, labelPlanes_, native::packetTarget()));
    action();
    sceneLight_->castBy(nullptr);
}

void NativeEngine::castShadows() {
    if (!sceneLight_ || further_.empty())
        return;
    std::vector<NativeEngine*> all = {this};
    for (const auto& engine : further_)
        all.push_back(engine.get());
    for (NativeEngine* engine : all) {
        engine->lookAgain();
        engine->withRays([&] { engine->lightPlane_->makeMaps(); });
    }
    for (NativeEngine* engine : all) {
        std::vector<SceneLight*> others;
        for (NativeEngine* other : all)
            if (other != engine)
                others.push_back(&*other->sceneLight_);
        engine->lightPlane_->shadedBy(others);
    }
}

const std::vector<std::unique_ptr<HostPlane>>& NativeEngine::settledLight(Work& work) {
    if (!sceneLight_)
        return lightPlanes_;
    lookAgain();
    withRays([&] { lightPlane_->settle(work); });
    const Layer& volume = scene_->layer();
    for (const auto& plane : lightPlanes_)
        plane->settle(volume.mixed() ? &volume.levels : nullptr, volume.selection.finest());
    return lightPlanes_;
}

std::unique_ptr<RayCaster> NativeEngine::caster(const CasterOptions& options, MemoryBudget& gpu) {
    return std::make_unique<NativeCaster>(*scene_, *this, options, gpu);
}

std::unique_ptr<VisibilityCounter> NativeEngine::counter(MemoryBudget&) {
    return std::make_unique<NativeCounter>(*scene_, *this);
}

EngineTraits nativeTraits() {
    EngineTraits traits;
    traits.kind = EngineKind::native;
    traits.name = "native";
    traits.device = std::string("CPU, ") + native::packetTarget().name;
    traits.quick = traits.countsAlways = true;
    traits.fuses = traits.followsPaths = traits.drawsParts = true;
    traits.make = [](const EngineInput& input) -> std::unique_ptr<Engine> {
        return std::make_unique<NativeEngine>(input.threads, *input.gpu, *input.ram);
    };
    return traits;
}

} // namespace tessera

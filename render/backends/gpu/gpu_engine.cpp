// render/backends/gpu/gpu_engine.cpp: see gpu_engine.h.
#include "render/backends/gpu/gpu_engine.h"

#include "core/base/error.h"
#include "render/backends/gpu/march.h"
#include "render/backends/gpu/skipping_binding.h"
#include "render/backends/gpu/visibility_pass.h"
#include "render/contract/integrators.h"
#include "render/plan/fusion.h"
#include "render/residency/texels.h"

#include <utility>

namespace tessera {

namespace {

/// Of one volume's samples.
std::uint32_t featuresOfVolume(const FramePlan& volume) {
    std::uint32_t f = 0;
    const auto add = [&](bool needed, Feature feature) { f |= needed ? feature : 0u; };
    const Optics& optics = volume.layer().optics;
    add(volume.layer().mixed(), kFeatureMixed);
    add(optics.shading, kFeatureShading);
    add(optics.grades(), kFeatureGradientOpacity);
    add(optics.labels.count > 0, kFeatureLabels);
    if (optics.takesGradients() || !optics.surfaces.empty())
        f |= gradientFeature(optics.gradient);
    add(volume.layer().reduces(), kFeatureValues);
    add(texelFormat(volume.info().type).normalised, kFeatureNormalised);
    add(optics.termination > 0, kFeatureTermination);
    add(!optics.surfaces.empty(), kFeatureSurfaces);
    return withLights(f | integratorFeatures(optics.integrator), optics);
}

std::vector<const FramePlan*> plansOf(const FramePlan& scene) {
    std::vector<const FramePlan*> plans = {&scene};
    for (std::size_t n = 1; n < scene.volumesOfRays(); ++n)
        plans.push_back(&scene.further[n - 1].plan);
    return plans;
}

} // namespace

std::uint32_t marchFeatures(const FramePlan& scene, bool counting) {
    std::uint32_t f = 0;
    const auto add = [&](bool needed, Feature feature) { f |= needed ? feature : 0u; };
    for (const FramePlan* volume : plansOf(scene))
        f |= featuresOfVolume(*volume);
    const DrawnPart& part = scene.fused ? scene.fused->part : scene.view.part;
    add(scene.fused.has_value(), kFeatureFused);
    if (scene.fused)
        add(!scene.fused->cuts.slabs.empty() ||
                std::any_of(scene.further.begin(), scene.further.end(),
                            [](const auto& volume) { return !volume->cuts.slabs.empty(); }),
            kFeatureOwnCuts);
    add(scene.view.quality.skipping && (scene.layer().occupancy.exists() || scene.layer().bounds.exists()),
        kFeatureSkipping);
    add(!part.slabs.empty(), kFeatureSlabs);
    add(part.cuts != nullptr, kFeatureIntervals);
    add(scene.view.quality.fetch == Fetch::hardware, kFeatureHardware);
    add(counting, kFeatureCounting);
    return f;
}

namespace {

class GpuCounter : public VisibilityCounter {
  public:
    GpuCounter(const FramePlan& scene, GpuEngine& engine, MemoryBudget& gpu)
        : scene_(scene), engine_(engine), pass_(featuresOfVolume(scene), scene.info(), gpu) {}
    void begin() override {
        engine_.settlePlan();
        pass_.begin(
            visibilityRays(scene_.view.camera, scene_.info(), scene_.view.imageSize, scene_.strides()),
            scene_.layer().optics);
    }
    bool count(const Slicing& slicing, RayCaster::Clock::time_point deadline) override {
        Work work; // not the picture's
        return pass_.countUntil(engine_.field(), slicing, deadline, work);
    }
    std::vector<SeenBrick> seen() const override { return pass_.seen(); }

  private:
    const FramePlan& scene_;
    GpuEngine& engine_;
    VisibilityPass pass_;
};

} // namespace

Engine::About GpuEngine::about() const {
    About about;
    about.device = context_ ? context_->renderer() : "OpenGL";
    about.version = context_ ? context_->version() : "";
    about.choosesSteps = about.measures = about.compiles = about.filters = true;
    return about;
}

TextureLimits GpuEngine::limits() const {
    TextureLimits limits;
    if (context_) {
        limits.maxExtent = context_->max3dTextureSize();
        limits.maxBytes = context_->maxTextureBytes();
    }
    limits.readsOnce = true;
    return limits;
}

void GpuEngine::open(const FramePlan& plan, std::size_t pages) {
    close();
    scene_ = &plan; // first, so that two are never charged
    TextureLimits limits = this->limits();
    limits.channelsBeside = scene_->channelsBeside();
    std::vector<Plane*> beside;
    if (keptLightChannels(scene_->view.lighting) > 0)
        beside.push_back(&light_.emplace(*scene_, pages, limits, 0, gpu_).plane());
    if (scene_->layer().labels)
        beside.push_back(
            &labels_.emplace(*scene_->layer().labels, scene_->info(), pages, limits, gpu_).plane());
    litBy_ = scene_->view.camera;
    atlas_.emplace(scene_->info(), scene_->layer().selection, pages, limits, gpu_, ram_, std::move(beside));
    taken_ = scene_->revisions;
    takeLevels();
    for (const auto& volume : plan.further) {
        auto& engine = further_.emplace_back(std::make_unique<GpuEngine>(volume->gpu, volume->ram));
        engine->context_ = context_;
    }
}

void GpuEngine::close() {
    further_.clear();
    field_ = {};
    textures_.reset();
    uniformMap_.reset();
    atlas_.reset();
    light_.reset();
    labels_.reset();
    scene_ = nullptr;
}

void GpuEngine::settlePlan() {
    const PlanRevisions before = std::exchange(taken_, scene_->revisions);
    if (before.levels != taken_.levels)
        takeLevels();
    if (light_ && (before.function != taken_.function || before.tables != taken_.tables))
        light_->light().functionChanged();
}

void GpuEngine::takeLevels() {
    const Layer& volume = scene_->layer();
    uniformMap_.reset();
    if (!volume.mixed())
        textures_.reset();
    else if (textures_)
        textures_->upload(volume.levels);
    else
        textures_.emplace(volume.levels, gpu_);
    field_.atlas = &*atlas_;
    field_.level = volume.selection.finest();
    field_.map = textures_ ? &volume.levels : nullptr;
    field_.textures = textures_ ? &*textures_ : nullptr;
    field_.light = light_ ? &*light_ : nullptr;
    field_.labels = labels_ ? &*labels_ : nullptr;
    if (light_)
        light_->light().levelsChanged();
}

const FieldSource& GpuEngine::mixedField() {
    if (field_.map)
        return field_;
    const Layer& volume = scene_->layer();
    uniformMap_ = makeLevelMap(volume.selection, volume.info().extentVoxels, scene_->view.quality, ram_);
    textures_.emplace(*uniformMap_, gpu_);
    field_.map = &*uniformMap_;
    field_.textures = &*textures_;
    return field_;
}

/// Takes the camera that lights are fixed to.
void GpuEngine::lookAgain() {
    if (litBy_ == scene_->view.camera)
        return;
    litBy_ = scene_->view.camera;
    light_->light().viewChanged();
}

void GpuEngine::castShadows() {
    if (!light_ || further_.empty())
        return;
    std::vector<GpuEngine*> all = {this};
    for (const auto& engine : further_)
        all.push_back(engine.get());
    for (GpuEngine* engine : all) {
        engine->lookAgain();
        engine->light_->plane().makeMaps();
    }
    for (GpuEngine* engine : all) {
        std::vector<SceneLight*> others;
        for (GpuEngine* other : all)
            if (other != engine)
                others.push_back(&other->light_->light());
        engine->light_->plane().shadedBy(others);
    }
}

void GpuEngine::settleLight(Work& work) {
    if (!light_)
        return;
    lookAgain();
    light_->settle(work);
}

std::unique_ptr<RayCaster> GpuEngine::caster(const CasterOptions& options, MemoryBudget& gpu) {
    return std::make_unique<GpuCaster>(*scene_, *this, options, gpu);
}

std::unique_ptr<VisibilityCounter> GpuEngine::counter(MemoryBudget& gpu) {
    return std::make_unique<GpuCounter>(*scene_, *this, gpu);
}

std::string GpuEngine::fault() {
    return !context_ || context_->errors().empty() ? std::string() : "OpenGL: " + context_->errors().front();
}

EngineTraits gpuTraits() {
    EngineTraits traits;
    traits.kind = EngineKind::gpu;
    traits.name = "gpu";
    traits.onContext = traits.quick = traits.fuses = true;
    traits.refuses = [](const Scene& scene) { return cannotFuse(scene, fuseLimits()); };
    traits.make = [](const EngineInput& input) -> std::unique_ptr<Engine> {
        return std::make_unique<GpuEngine>(*input.context, *input.gpu, *input.ram);
    };
    return traits;
}

namespace {

/// That its function, which may change, decides about.
std::uint32_t withFunction(std::uint32_t features, const std::vector<const FramePlan*>& plans) {
    std::uint32_t needed = 0;
    for (const FramePlan* plan : plans) {
        const Optics& optics = plan->layer().optics;
        needed |= withGradientOpacity(
            withLights((features & ~kIntegratorFeatures) | integratorFeatures(optics.integrator), optics),
            optics);
    }
    return needed;
}

/// What rays go through, of all volumes.
/// @param gpu  for that of the first
std::vector<VolumeToMarch> volumesOf(const FramePlan& scene, std::uint32_t features, MemoryBudget& gpu) {
    std::vector<VolumeToMarch> all;
    const auto add = [&](const FramePlan& plan, const glm::dmat4& fromLattice, MemoryBudget& budget,
                         std::span<const leaf::CutSlab> cuts) {
        const Layer& layer = plan.layer();
        all.push_back({&plan.info(), &layer.optics,
                       (features & kFeatureSkipping) && !layer.reduces() ? &layer.occupancy : nullptr,
                       &budget, fromLattice, layer.function.referenceLengthMm(), cuts});
    };
    if (!scene.fused)
        add(scene, glm::dmat4(1), gpu, {});
    else
        add(scene, scene.fused->fromLattice, gpu, scene.fused->cuts.slabs);
    for (std::size_t n = 1; n < scene.volumesOfRays(); ++n) {
        FurtherVolume& volume = scene.further[n - 1];
        add(volume.plan, volume.fromLattice, volume.gpu, volume.cuts.slabs);
    }
    return all;
}

std::vector<const Optics*> opticsOf(const std::vector<const FramePlan*>& plans) {
    std::vector<const Optics*> all;
    for (const FramePlan* plan : plans)
        all.push_back(&plan->layer().optics);
    return all;
}

std::uint32_t featuresOf(const FramePlan& scene, const CasterOptions& options) {
    return marchFeatures(scene, options.counting) | (options.hits ? kFeatureHits : 0u) |
           (options.passes ? kFeaturePasses : 0u);
}

} // namespace

GpuCaster::GpuCaster(const FramePlan& scene, GpuEngine& engine, const CasterOptions& options,
                     MemoryBudget& gpu)
    : GpuCaster(scene, engine, featuresOf(scene, options), gpu) {}

GpuCaster::GpuCaster(const FramePlan& scene, GpuEngine& engine, std::uint32_t features, MemoryBudget& gpu)
    : scene_(scene), engine_(engine), gpu_(gpu), plans_(plansOf(scene)),
      features_(withFunction(features, plans_)), fetch_(scene.view.quality.fetch),
      march_(features, scene.view.frame, scene.strides(), volumesOf(scene, features, gpu),
             scene.fused ? scene.fused->rule : Fusion::mix, gpu) {
    for (const FramePlan* plan : plans_)
        taken_.push_back(plan->revisions);
    putBounds();
    if ((features & kFeatureSkipping) && scene.layer().mapsSurfaces)
        march_.setSurfaceMap(scene.layer().surfaceOccupancy);
}

void GpuCaster::begin(const Rays& rays) {
    check(rays);
    bool function = false;
    std::vector<const Occupancy*> changed(plans_.size(), nullptr);
    for (std::size_t n = 0; n < plans_.size(); ++n) {
        (n == 0 ? engine_ : *engine_.further(n - 1)).settlePlan();
        const PlanRevisions last = std::exchange(taken_[n], plans_[n]->revisions);
        function = function || last.function != taken_[n].function || last.tables != taken_[n].tables;
        if (last.emptySpace != taken_[n].emptySpace && (features_ & kFeatureSkipping) != 0 &&
            !scene_.layer().reduces())
            changed[n] = &plans_[n]->layer().occupancy;
    }
    if (function)
        takeFunction();
    const std::uint32_t before = features_;
    if (const Fetch fetch = scene_.view.quality.fetch; fetch != std::exchange(fetch_, fetch))
        features_ = (features_ & ~std::uint32_t{kFeatureHardware}) |
                    (fetch == Fetch::hardware ? std::uint32_t{kFeatureHardware} : 0u);
    features_ = (features_ & ~std::uint32_t{kFeaturePlaces | kFeatureSlabs | kFeatureIntervals}) |
                (rays.frame.cuts ? std::uint32_t{kFeatureIntervals} : 0u) |
                (rays.places.empty() ? 0u : std::uint32_t{kFeaturePlaces}) |
                (rays.frame.slabCount > 0 ? std::uint32_t{kFeatureSlabs} : 0u);
    if (features_ != before)
        march_.setFeatures(features_, opticsOf(plans_));
    putBounds();
    march_.setLights(opticsOf(plans_)); // the camera may be another
    march_.restart(rays, changed);
}

/// Those of rays that keep one value, where they are others than on the device.
void GpuCaster::putBounds() {
    const ValueBounds& bounds = scene_.layer().bounds;
    if (!(features_ & kFeatureSkipping) || !scene_.layer().reduces() || boundsVersion_ == bounds.version())
        return;
    march_.setBounds(bounds);
    boundsVersion_ = bounds.version();
}

Image GpuCaster::image() const {
    Image image = march_.image();
    if ((features_ & kFeatureIntervals) && (features_ & kFeatureValues))
        for (glm::vec4& p : image.pixels)
            p = colourOfKept(scene_.layer().optics, KeptValue<float>{p.r, p.g, p.a > 0});
    return image;
}

bool GpuCaster::draw(const Slicing& slicing, Clock::time_point deadline, Work& work) {
    engine_.castShadows();
    std::vector<const FieldSource*> sources;
    for (std::size_t n = 0; n < plans_.size(); ++n) {
        GpuEngine& engine = n == 0 ? engine_ : *engine_.further(n - 1);
        engine.settleLight(work);
        sources.push_back(scene_.fused && (features_ & kFeatureMixed) ? &engine.mixedField()
                                                                      : &engine.field());
    }
    return march_.runUntil(sources, slicing, deadline, work);
}

void GpuCaster::takeFunction() {
    features_ = withFunction(features_, plans_);
    march_.setFunction(opticsOf(plans_));
}

void GpuCaster::refine() {
    if (!(features_ & kFeatureSkipping) || (features_ & kFeaturePasses) || scene_.layer().reduces() ||
        scene_.layer().showsMedium() || scene_.fused)
        return;
    engine_.settlePlan();
    const Layer& volume = scene_.layer();
    const auto refined = [&](const GlTexture3d& map, const Occupancy& occupancy, const TransferTable& table) {
        if (!refiningPays(occupancy, rayCount(scene_.view.imageSize)) ||
            gpu_.freeBytes() < refiningBytes(table.entries.size()))
            return std::size_t{0};
        return refineSkipping(map, occupancy, table, volume.optics, features_, scene_.info(), engine_.field(),
                              gpu_);
    };
    if (volume.mapsSurfaces)
        refined(march_.surfaceMap(), volume.surfaceOccupancy, volume.surfaceTable);
    refinedCells_ = refined(march_.skippingMap(), volume.occupancy, volume.table);
}

} // namespace tessera

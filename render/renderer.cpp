// render/renderer.cpp: see renderer.h.
#include "render/renderer.h"

#include "core/error.h"
#include "render/engines/gpu/features.h"
#include "render/engines/gpu/gpu_engine.h"
#include "render/engines/mirror/mirror_engine.h"
#include "render/engines/mirror/mirror_tracer.h"
#include "render/engines/native/native_engine.h"
#include "render/engines/reference/reference.h" // ReferenceRay
#include "render/engines/reference/reference_engine.h"
#include "render/frame_renderer.h"
#include "render/picture.h"
#include "render/plan/overlooked_pixels.h"
#include "render/plan/plan_again.h"
#include "render/plan/step_search.h"
#include "render/step_of_means.h"
#include "render/verify/error_goal.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <optional>
#include <utility>

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What eight bits can show.
constexpr double kDefaultStepError = 1.0 / 255;

/// What a ray through a place comes to depends on these, in one scene on one engine.
struct RaysDrawn {
    std::vector<std::uint8_t> levels;
    double stepVoxels;
    Integrator integrator;
    explicit RaysDrawn(const ScenePlan& p)
        : levels(p.volume.selection.levels), stepVoxels(p.view.quality.stepVoxels),
          integrator(p.volume.optics.integrator) {}
    friend bool operator==(const RaysDrawn&, const RaysDrawn&) = default;
};

/// Samples of a picture: the next one of the same rays goes on from them.
struct SamplesDrawn {
    RaysDrawn rays;
    AreaPicture picture;
    std::unique_ptr<SurfaceLight> light = {}; // occlusion of surfaces, where there is any
};

std::unique_ptr<SurfaceTracer> tracerOf(const RayCaster& caster, const ScenePlan& p) {
    auto tracer = caster.surfaceTracer(SurfaceLight::kSegmentVoxels);
    return tracer ? std::move(tracer) : std::make_unique<MirrorTracer>(p, SurfaceLight::kSegmentVoxels);
}

/// Looks around from what the rays of the caster met, which are those through the middles of pixels.
void lookAround(SurfaceLight& light, const RayCaster& caster, const ScenePlan& p, Progress& progress) {
    progress.stage("looking around from surfaces");
    light.look(caster.hits(), *tracerOf(caster, p), progress.shares());
    progress.stage("drawing");
}

/// Every pixel the mean of its samples. Returns whether it went on from earlier ones.
/// @param light  none: there is no occlusion of surfaces; else what is added by it is another picture
bool drawAreas(RayCaster& caster, Engine& engine, const ScenePlan& p, const RenderOptions& options,
               const PixelGoal& goal, std::optional<SamplesDrawn>& samples,
               std::unique_ptr<SurfaceLight> light, Image& added, Progress& progress, RenderResult& result) {
    RaysDrawn these(p);
    const bool goesOn =
        samples && samples->rays == these && p.view.quality.pixels.samples == PixelSampling::kAutomatic;
    if (goesOn)
        samples->picture.goOn(goal);
    else
        samples = SamplesDrawn{std::move(these),
                               AreaPicture(
                                   raysOf(p), p.view.quality.pixels, options.threads, goal,
                                   [&p](const Image& middles) { return overlookedPixels(p, middles); },
                                   result.stepOfMeans)};
    if (!goesOn)
        samples->light = std::move(light);
    AreaPicture& picture = samples->picture;
    SurfaceLight* const looks = samples->light.get();
    Slicing slicing = options.slicing;
    const ShareDone whole = progress.shares();
    if (whole)
        slicing.progress = [&](double done) { whole(picture.share(done)); };
    while (const std::optional<Rays> rays = picture.next()) {
        if (looks && !looks->hasLooked() && !rays->places.empty()) { // it takes what middles met
            caster.begin(raysOf(p));
            result.passes =
                std::max(result.passes, drawToTheEnd(caster, engine, p, options.slicing, result.work));
            lookAround(*looks, caster, p, progress);
        }
        caster.begin(*rays);
        result.passes = std::max(result.passes, drawToTheEnd(caster, engine, p, slicing, result.work));
        if (!looks) {
            picture.add(caster.image());
            continue;
        }
        if (!looks->hasLooked())
            lookAround(*looks, caster, p, progress);
        const Image more = looks->added(caster.hits(), rays->places, rays->size(), *tracerOf(caster, p));
        picture.add(caster.image(), &more);
    }
    result.image = picture.image();
    if (looks) {
        added = picture.light();
        result.surfaceLight = looks->report();
    }
    result.pixels = picture.report();
    return goesOn;
}

/// What the selection came to; after it is final.
void report(const ScenePlan& p, RenderResult& result) {
    result.level = p.volume.selection.finest();
    result.integrator = p.volume.optics.integrator;
    result.stepVoxels = p.view.quality.stepVoxels;
    result.bricksOfLevel = p.volume.selection.counts;
    result.selectionPages = pagesFor(p.volume.selection.counts);
    result.atlasPages = std::min(p.chosen.atlasPages, result.selectionPages);
    if (p.chosen.predicted)
        result.predictedError = p.chosen.error;
    result.residentBricks = p.volume.selection.shownBricks();
    result.unseenBricks = p.chosen.unseenBricks;
    result.emptyBricks = p.volume.selection.counts[Selection::kEmpty] - result.unseenBricks;
}

/// Of pictures that follow one another.
struct Keeping {
    bool kept = false; // the engine holds the bricks of the picture before
    std::size_t pages =
        0; // to open the engine with, so that the next pictures' bricks have room; 0: the plan's
    std::function<void()> opened; // the engine has what it takes of RAM
    bool first = false;           // a first, coarse picture: without occlusion of surfaces
};

/// The picture of a plan, by any engine: bricks are brought, a step is chosen, rays are drawn, errors told.
/// Returns whether it went on from samples that were there.
bool drawPicture(const Scene& scene, ScenePlan& p, Engine& engine, Ledger& ram, Ledger& gpu,
                 const RenderOptions& options, int round, const PixelGoal& goal,
                 std::optional<SamplesDrawn>& samples, Progress& progress, RenderResult& result,
                 const Keeping& keeping = {}) {
    progress.stage("loading bricks");
    const auto loading = Clock::now();
    const bool passes = bringBricks(engine, p, ram, gpu, result.work, keeping.kept, keeping.pages);
    if (keeping.opened)
        keeping.opened();
    std::unique_ptr<SurfaceLight> light;
    if (p.view.lighting.surfaceOcclusion && !keeping.first)
        light = std::make_unique<SurfaceLight>(p, options.threads, result.engine == EngineKind::reference);
    std::unique_ptr<RayCaster> caster = engine.caster({options.counting, light != nullptr, passes}, gpu);
    result.secondsLoading = secondsSince(loading);
    const auto drawing = Clock::now();
    result.refinedCells = caster->refine();
    const auto drawSome = [&](const Rays& rays) {
        Work work; // not the picture's
        caster->begin(rays);
        drawToTheEnd(*caster, engine, p, options.slicing, work);
        return caster->image();
    };
    const bool checks = engine.about().choosesSteps;
    const bool steps = checks && !p.view.part.flat; // a plane has one sample
    StepSearch search(p,
                      {[&](const RayFrame<double>& frame, const Strides& strides) {
                           return drawSome({frame, strides});
                       },
                       [&] { caster->functionChanged(); }, [&] { return caster->fetchExactly(); }},
                      ram);
    using Goal = StepSearch::Goal;
    result.stepOfMeans.reset();
    if (steps) {
        progress.stage("choosing the step");
        const bool chosen = scene.quality.automaticStep && (options.searching || options.checking);
        if (scene.quality.maxError.value_or(0) > 0)
            search.chooseStep({Goal::Measure::luvP99, *scene.quality.maxError - p.chosen.error.p99});
        else if (chosen)
            search.chooseStep({Goal::Measure::rms, kDefaultStepError});
        const bool decide = p.view.quality.pixels.samples == PixelSampling::kAutomatic;
        if (chosen && decide && !scene.quality.maxError)
            result.stepOfMeans = stepOfMeans(p, kDefaultStepError, drawSome);
    }
    progress.stage("drawing");
    const bool areas = p.view.quality.pixels.samples != 1;
    bool wentOn = false;
    Image added; // to the picture, once its errors are known: they are those of rays
    if (areas) {
        wentOn =
            drawAreas(*caster, engine, p, options, goal, samples, std::move(light), added, progress, result);
    } else {
        Slicing slicing = options.slicing;
        slicing.progress = progress.shares();
        caster->begin(raysOf(p));
        result.passes = drawToTheEnd(*caster, engine, p, slicing, result.work);
        result.image = caster->image();
        if (light) {
            lookAround(*light, *caster, p, progress);
            added = light->added(light->middles(), {}, p.view.imageSize, *tracerOf(*caster, p));
            result.surfaceLight = light->report();
        }
    }
    if (!engine.bricks())
        result.passes = 0;
    result.features = caster->features();
    result.light = engine.lightReport();
    result.secondsDrawing = secondsSince(drawing);
    const auto checking = Clock::now();
    if (steps && options.checking) {
        progress.stage("estimating the picture's errors");
        const double most = brightest(scene.shading, scene.lighting, p.volume.function.materials());
        result.errors = areas ? search.errors(most) : search.errorsOf(result.image, most);
        if (p.chosen.predicted)
            result.errors->levelsLuvP99 = p.chosen.error.p99;
    }
    report(p, result);
    if (checks && options.verify != Verify::none) {
        progress.stage("measuring the picture's errors");
        const bool decides = scene.quality.maxError.value_or(0) > 0;
        const DrawnPicture drawn{scene,
                                 result.image,
                                 result.work,
                                 result.pixels.taken,
                                 decides ? Verify::full : options.verify,
                                 round,
                                 decides ? ErrorGoal::kMostRounds : 1,
                                 options.threads,
                                 options.slicing};
        caster->fetchAsAsked(); // estimates fetched exactly
        result.measured = measurePicture(drawn, p, engine, caster, ram, gpu);
    }
    for (std::size_t i = 0; i < added.pixels.size(); ++i)
        result.image.pixels[i] = glm::max(result.image.pixels[i] + added.pixels[i], glm::vec4(0));
    result.secondsChecking = secondsSince(checking);
    if (const std::string fault = engine.fault(); !fault.empty())
        throw Error(fault);
    return wentOn;
}

/// Samples until every pixel's standard error is within what is asked, at any cost.
PixelGoal pixelGoal(double lightness) {
    PixelGoal goal;
    goal.target.linear *= lightness / goal.target.lightness;
    goal.target.lightness = lightness;
    goal.rays = SIZE_MAX / 4;
    goal.most = PixelSampling::kMost;
    return goal;
}

/// Pictures, each finer than the one before, until the measured error is within what is asked.
void drawUntilGoodEnough(const Scene& scene, ScenePlan& p, Engine& engine, Ledger& ram, Ledger& gpu,
                         const RenderOptions& options, Progress& progress, RenderResult& result) {
    ErrorGoal goal(*scene.quality.maxError);
    Scene now = scene;
    std::optional<SamplesDrawn> samples;
    double lastTarget = std::numeric_limits<double>::max(), lastTaken = 0;
    for (int round = 0;; ++round) {
        const double target = goal.ofSamples();
        now.quality.maxError = goal.ofRays();
        if (round > 0) {
            engine.close();
            progress.stage("choosing finer levels");
            chooseAgain(p, now, engine.limits(), ram, gpu, options.threads, options.levels);
        }
        const bool wentOn = drawPicture(now, p, engine, ram, gpu, options, round, pixelGoal(target), samples,
                                        progress, result);
        result.rounds = round + 1;
        const PictureMeasurement& m = *result.measured;
        const bool finest = result.bricksOfLevel[0] == result.residentBricks &&
                            (p.view.part.flat || result.stepVoxels <= StepSearch::kFinestStep);
        const bool most = scene.quality.pixels.samples != PixelSampling::kAutomatic ||
                          (wentOn && target < lastTarget && result.pixels.taken <= lastTaken);
        lastTarget = target, lastTaken = result.pixels.taken;
        const auto verdict = goal.judge(m.all, m.sampling, m.rays, finest, most);
        result.shortfall = goal.shortfall();
        if (!m.whyNot.empty())
            result.shortfall += ": " + m.whyNot;
        if (verdict != ErrorGoal::Verdict::goOn)
            return;
    }
}

/// A first picture is drawn with: a sample of the coarse level a step, not two, and nothing tried or
/// estimated.
Scene firstScene(const Scene& scene) {
    Scene first = scene;
    first.quality.stepVoxels = std::min(2 * scene.quality.stepVoxels, 16.0);
    first.quality.automaticStep = false;
    first.quality.maxError.reset();
    first.quality.pixels.samples = 1;
    return first;
}

/// Seconds that the picture itself takes, from how long the first one took: it takes as many more samples as
/// its level and step are finer. What is tried and estimated besides takes about a third of it again.
double secondsAfterFirst(const RenderResult& first, const Scene& scene) {
    const double samplesPerSample = (1 << first.level) * first.stepVoxels / scene.quality.stepVoxels;
    return 1.3 * samplesPerSample * 1e-3 * first.work.marchMs;
}

} // namespace

const char* name(EngineKind engine) {
    switch (engine) {
    case EngineKind::automatic:
        return "auto";
    case EngineKind::gpu:
        return "gpu";
    case EngineKind::native:
        return "native";
    case EngineKind::mirror:
        return "mirror";
    case EngineKind::reference:
        return "reference";
    }
    return "?";
}

std::size_t pictureBytesPerPixel(EngineKind engine) {
    if (engine == EngineKind::reference) // its rays, their colours, and the picture made from them
        return std::max(kPictureBytesPerPixel, sizeof(ReferenceRay) + sizeof(glm::dvec4) + sizeof(glm::vec4));
    return kPictureBytesPerPixel;
}

std::size_t pictureBytesPerPixel(EngineKind engine, const PixelSampling& pixels) {
    return pictureBytesPerPixel(engine) + (pixels.samples == 1 ? 0 : AreaPicture::bytesPerPixel());
}

/// OpenGL is not even loaded where the system knows of no GPU.
EngineMaker::EngineMaker(EngineKind asked, const GlDeviceChoice& device, int threads)
    : kind_(asked), threads_(threads) {
    if (kind_ == EngineKind::automatic) {
        kind_ = EngineKind::gpu;
        if (device.text != "auto") {
            reason_ = "a device of OpenGL was asked for";
        } else if (mayHaveGpu()) {
            try {
                context_.emplace(device);
                reason_ = context_->software() ? "OpenGL draws in software here" : "this machine has a GPU";
            } catch (const Error& e) {
                reason_ = e.what();
            }
            if (!context_ || context_->software()) {
                context_.reset();
                kind_ = EngineKind::native;
            }
        } else {
            reason_ = "this machine has no GPU";
            kind_ = EngineKind::native;
        }
    }
    if (kind_ == EngineKind::gpu && !context_)
        context_.emplace(device);
}

std::unique_ptr<Engine> EngineMaker::make(Ledger& ram, Ledger& gpu) const {
    switch (kind_) {
    case EngineKind::gpu:
        return std::make_unique<GpuEngine>(*context_, gpu, ram);
    case EngineKind::native:
        return std::make_unique<NativeEngine>(threads_, gpu, ram);
    case EngineKind::mirror:
        return std::make_unique<MirrorEngine>(threads_);
    case EngineKind::automatic:
    case EngineKind::reference:
        break;
    }
    TESSERA_CHECK(false);
    return nullptr;
}

std::string EngineMaker::about() const {
    const std::string device = context_ ? context_->renderer()
                               : kind_ == EngineKind::native
                                   ? std::string("CPU, ") + native::packetTarget().name
                                   : "CPU";
    return std::string(name(kind_)) + " engine, " + device;
}

std::string EngineMaker::fault() const {
    return context_ && !context_->errors().empty() ? "OpenGL: " + context_->errors().front() : std::string();
}

/// An engine and what it draws with.
struct MadeEngine {
    EngineMaker maker;
    EngineKind kind;
    std::string reason; // why this one; empty where it was asked for
    std::unique_ptr<Engine> engine;

    MadeEngine(const Scene& scene, const RenderOptions& options, Ledger& ram, Ledger& gpu)
        : maker(options.engine, options.device, options.threads), kind(maker.kind()), reason(maker.reason()) {
        if (kind == EngineKind::reference)
            engine = std::make_unique<ReferenceEngine>(scene, options.threads);
        else
            engine = maker.make(ram, gpu);
    }
};

std::shared_ptr<Engine> makeEngine(const Scene& scene, const RenderOptions& options, Ledger& ram,
                                   Ledger& gpu) {
    auto made = std::make_shared<MadeEngine>(scene, options, ram, gpu);
    Engine* const engine = made->engine.get();
    return {std::move(made), engine};
}

namespace {

/// A picture by an engine that holds nothing, or the bricks of the picture before.
/// @param p  takes the plan; where bricks are kept, the engine was opened for what is in its place
/// @param planned  makes the plan, and may change what is kept
template <typename Planned>
RenderResult drawScene(const Scene& scene, ScenePlan& p, const MadeEngine& made, Ledger& ram, Ledger& gpu,
                       const RenderOptions& options, const Keeping& keeping, const Planned& planned) {
    RenderResult result;
    const auto start = Clock::now();
    Engine& engine = *made.engine;
    const TextureLimits limits = engine.limits();
    const Engine::About about = engine.about();
    result.device = about.device;
    result.glVersion = about.version;
    result.engine = made.kind;
    result.engineReason = made.reason;
    Progress silent;
    Progress& progress = options.progress ? *options.progress : silent;
    progress.stage("reading statistics and choosing levels");
    const bool first =
        options.onFirstPicture && (made.kind == EngineKind::gpu || made.kind == EngineKind::native);
    const bool decides = // how fine it is, by what is measured
        scene.quality.maxError.value_or(0) > 0 && options.verify != Verify::none && about.choosesSteps;
    Scene picture = scene; // the first that is drawn in full
    if (decides)
        picture.quality.maxError = ErrorGoal(*scene.quality.maxError).ofRays();
    const Scene coarse = first ? firstScene(scene) : picture;
    p = planned(coarse, limits, first ? LevelChoice::quick : options.levels,
                pictureBytesPerPixel(made.kind, scene.quality.pixels) +
                    (scene.lighting.surfaceOcclusion
                         ? SurfaceLight::bytesPerPixel(scene.quality.pixels.samples != 1)
                         : 0));
    p.view.shadowQuality.layers = options.shadowLayers;
    std::optional<SamplesDrawn> ofOnePicture; // that no other goes on from
    if (first) {
        RenderResult quick;
        RenderOptions plain = options;
        plain.checking = plain.searching = false;
        plain.verify = Verify::none;
        Keeping nothing;
        nothing.first = true;
        drawPicture(coarse, p, engine, ram, gpu, plain, 0, {}, ofOnePicture, progress, quick, nothing);
        options.onFirstPicture(quick.image, secondsAfterFirst(quick, scene));
        quick = {};
        engine.close();
        progress.stage("choosing levels");
        chooseAgain(p, picture, limits, ram, gpu, options.threads, options.levels);
    }
    result.camera = p.view.camera;
    result.tableRelativeError = p.volume.table.relativeError;
    result.levelsOnPurpose = options.levels != LevelChoice::perBrick || made.kind == EngineKind::reference;
    result.cells = cellCount(p.volume.statistics.cells);
    const SceneVolume& volume = scene.volumes.front();
    const ValueSummary values = summarise(p.volume.statistics, p.info(), volume.unit);
    const auto* const preset = std::get_if<std::string>(&volume.transferFunction);
    result.takenAsHu = preset && *preset != "auto" && !values.isHu;
    result.lowest = values.lowest;
    result.highest = values.highest;
    result.secondsPreparing = secondsSince(start);

    if (decides)
        drawUntilGoodEnough(scene, p, engine, ram, gpu, options, progress, result);
    else
        drawPicture(scene, p, engine, ram, gpu, options, 0, {}, ofOnePicture, progress, result, keeping);
    if (made.kind == EngineKind::reference)
        result.level = 0;
    result.occupiedCells = scene.quality.skipping && p.volume.occupancy.exists()
                               ? p.volume.occupancy.occupiedCells()
                               : result.cells;
    result.window = p.volume.look.window;
    return result;
}

/// The same but for the camera.
bool sameButCamera(const Scene& a, const Scene& b) {
    Scene x = a, y = b;
    x.camera = y.camera = Camera{};
    return sceneJson(x) == sceneJson(y);
}

} // namespace

RenderResult renderScene(const Scene& given, const StoreReader& store, Ledger& ram, Ledger& gpu,
                         const RenderOptions& options) {
    const Scene scene = asDrawn(given);
    const auto start = Clock::now();
    const MadeEngine made(scene, options, ram, gpu);
    const double making = secondsSince(start);
    ScenePlan p;
    RenderResult result = drawScene(
        scene, p, made, ram, gpu, options, {},
        [&](const Scene& first, const TextureLimits& limits, LevelChoice levels, std::size_t bytesPerPixel) {
            return planScene(first, store, limits, ram, gpu, options.threads, levels, bytesPerPixel);
        });
    made.engine->close(); // it reads the plan, which goes first
    result.secondsPreparing += making;
    return result;
}

struct FrameRenderer::State {
    const StoreReader& store;
    Ledger &ram, &gpu;
    RenderOptions options;
    /// What the engine takes of RAM must not matter to who plans the next picture, as it does not for a
    /// still: it is charged to ram while a picture is drawn.
    Ledger engineRam;
    std::optional<MadeEngine> made;
    ScenePlan p; // stays where it is: the engine was opened for it
    std::optional<Scene> last;
    std::optional<Statistics> statistics;
    Charge heldRam;
    std::size_t gpuBefore = 0; // in use when the engine holds nothing
    Keeping keeping;           // kept: the engine holds bricks of the last picture

    State(const StoreReader& reader, Ledger& ramLedger, Ledger& gpuLedger, const RenderOptions& given)
        : store(reader), ram(ramLedger), gpu(gpuLedger), options(given),
          engineRam(ram.name(), ram.option(), ram.limitBytes()) {
        keeping.opened = [this] {
            heldRam = {};
            heldRam = ram.charge(engineRam.usedBytes(), "the brick index");
        };
    }
    ScenePlan plan(const Scene& scene, const TextureLimits& limits, LevelChoice choice,
                   std::size_t bytesPerPixel) {
        // As if the engine held nothing.
        Ledger free(gpu.name(), gpu.option(), gpu.limitBytes());
        const Charge before = free.charge(gpuBefore, "the device");
        if (!statistics)
            return planScene(scene, store, limits, ram, free, options.threads, choice, bytesPerPixel);
        Statistics known = std::move(*statistics);
        statistics.reset();
        return planAgain(scene, store, std::move(known), limits, ram, free, options.threads, choice,
                         bytesPerPixel);
    }
    /// Whether the bricks of the last picture serve this one.
    /// @param pageEdge, levels  of the last picture
    bool serves(const ScenePlan& plan, int pageEdge, const std::vector<std::uint8_t>& levels) const {
        const BrickResidency* const bricks = made->engine->bricks();
        return bricks && bricks->pages() >= plan.chosen.atlasPages && holdsAll(plan) &&
               plan.volume.pageEdge == pageEdge &&
               // light of voxels is that of the bricks as they are
               (lightChannels(plan.view.lighting) == 0 || levels == plan.volume.selection.levels) &&
               gpu.usedBytes() + plan.memory.gpuBytes() <= gpu.limitBytes();
    }
    /// Room for a quarter more bricks than the picture has, where there is any.
    std::size_t roomyPages(const ScenePlan& plan, TextureLimits limits) const {
        if (!holdsAll(plan))
            return 0;
        limits.pageEdge = plan.volume.pageEdge;
        limits.lightChannels = keptLightChannels(plan.view.lighting);
        const std::size_t fixed = gpuBefore + plan.memory.gpuBytes();
        const std::size_t fit =
            pagesThatFit(gpu.limitBytes() - std::min(gpu.limitBytes(), fixed), plan.info().type, limits);
        return std::min(fit, plan.chosen.atlasPages + plan.chosen.atlasPages / 4 + 16);
    }
    /// Every brick has its place, at levels that no picture decides about.
    static bool holdsAll(const ScenePlan& plan) {
        return !plan.chosen.chooser && plan.chosen.atlasPages >= pagesFor(plan.volume.selection.counts);
    }
};

namespace {
/// RAM that was never used, where bricks are kept: planning a picture takes about as much as planning the one
/// before.
constexpr std::size_t kAmpleBytes = std::size_t{64} << 20;
} // namespace

FrameRenderer::FrameRenderer(const StoreReader& store, Ledger& ram, Ledger& gpu, const RenderOptions& options)
    : state_(std::make_unique<State>(store, ram, gpu, options)) {
    TESSERA_CHECK(!options.onFirstPicture);
}

FrameRenderer::~FrameRenderer() {
    forget();
}

void FrameRenderer::forget() {
    State& s = *state_;
    if (s.made)
        s.made->engine->close();
    s.keeping.kept = false;
    s.heldRam = {};
}

RenderResult FrameRenderer::draw(const Scene& given) {
    State& s = *state_;
    // An engine of one scene; and measuring errors has another plan opened.
    if (s.options.engine == EngineKind::reference || s.options.verify != Verify::none) {
        ++kept_.frames;
        return renderScene(given, s.store, s.ram, s.gpu, s.options);
    }
    const Scene scene = asDrawn(given);
    if (!s.made) {
        s.made.emplace(scene, s.options, s.engineRam, s.gpu);
        s.gpuBefore = s.gpu.usedBytes();
    }
    Engine& engine = *s.made->engine;
    if (s.keeping.kept && !sameButCamera(*s.last, scene))
        forget();
    const int pageEdge = s.p.volume.pageEdge;
    const std::vector<std::uint8_t> levels = std::move(s.p.volume.selection.levels);
    if (std::exchange(s.last, std::nullopt))
        s.statistics = std::move(s.p.volume.statistics);
    s.heldRam = {};
    s.p = ScenePlan(); // gives back what the last picture took, as if it had never been
    try {
        const auto planned = [&](const Scene& first, const TextureLimits& limits, LevelChoice choice,
                                 std::size_t bytesPerPixel) {
            ScenePlan p = s.plan(first, limits, choice, bytesPerPixel);
            if (s.keeping.kept && !s.serves(p, pageEdge, levels))
                forget();
            s.keeping.pages = s.roomyPages(p, limits);
            return p;
        };
        RenderResult result = drawScene(scene, s.p, *s.made, s.ram, s.gpu, s.options, s.keeping, planned);
        ++kept_.frames;
        kept_.goneOn += s.keeping.kept ? 1 : 0;
        kept_.brought += result.work.bytesUploaded;
        s.last = scene;
        s.keeping.kept = engine.bricks() && State::holdsAll(s.p) &&
                         s.p.view.quality.maxError.value_or(0) == 0 &&
                         s.ram.limitBytes() - s.ram.peakBytes() >= kAmpleBytes + s.engineRam.usedBytes();
        s.p.volume.cache.reset();
        if (!s.keeping.kept)
            forget();
        return result;
    } catch (...) {
        forget();
        s.p = ScenePlan();
        s.statistics.reset();
        throw;
    }
}

std::vector<std::string> explain(const RenderResult& r, const Scene& scene) {
    std::vector<std::string> lines;
    const auto line = [&](const char* format, auto... values) {
        char text[256];
        std::snprintf(text, sizeof text, format, values...);
        lines.emplace_back(text);
    };
    const auto percent = [](std::size_t part, std::size_t whole) {
        return whole ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
    };
    line("engine: %s%s%s", name(r.engine), r.engineReason.empty() ? "" : ", because ",
         r.engineReason.c_str());
    if (r.glVersion.empty())
        line("device: %s", r.device.c_str());
    else {
        line("device: %s, OpenGL %s", r.device.c_str(), r.glVersion.c_str());
        for (const FeatureName& f : featureNames())
            line("%s: %s", f.meaning, (r.features & f.bit) ? "compiled in" : "left out");
    }
    for (int level = 0; level < kLevelCount; ++level)
        if (const std::size_t bricks = r.bricksOfLevel[static_cast<std::size_t>(level)]; bricks > 0)
            line("level %d: %zu bricks, a sample stands for %d^3 voxels", level, bricks, 1 << level);
    if (r.passes > 0)
        line("atlas: %zu pages of 32^3 texels, %zu at once, %d %s", r.selectionPages, r.atlasPages, r.passes,
             r.passes == 1 ? "pass" : "passes");
    const Reduction reduction = reductionOf(scene);
    if (reduction != Reduction::composite) {
        line("mode: %s; rays keep the %s value along them%s",
             modeNames()[static_cast<std::size_t>(scene.mode)].c_str(),
             scene.mode == Mode::slice && !(scene.slice.thicknessMm > 0) ? "plane's"
             : reduction == Reduction::average                           ? "mean"
             : reduction == Reduction::minimum                           ? "least"
                                                                         : "greatest",
             "; light, isosurfaces, integrator and opacities are not used");
        if (scene.valueColour == ValueColour::window)
            line("window: centre %g, width %g%s", r.window.centre, r.window.width,
                 ", greys of an sRGB display");
        else
            line("colours of values: the transfer function's");
    } else if (scene.mode == Mode::isosurface) {
        line("mode: isosurface; the transfer function shows nothing");
    }
    if (reduction != Reduction::composite && !r.levelsOnPurpose)
        line("level of detail: one level for all; what levels cost is not predicted in this mode");
    else if (!r.predictedError && !r.levelsOnPurpose)
        line("level of detail: one level for all, because this budget of RAM cannot hold what choosing by "
             "brick needs");
    if (r.predictedError)
        line("level of detail: predicted error (L*u*v*) %.2g in the mean, %.2g at the 99th percentile",
             r.predictedError->mean, r.predictedError->p99);
    line("bricks: %zu resident, %zu (%.1f %%) show nothing and take no memory", r.residentBricks,
         r.emptyBricks, percent(r.emptyBricks, r.residentBricks + r.emptyBricks + r.unseenBricks));
    if (r.unseenBricks > 0)
        line("bricks: %zu lie outside the picture, or of what is drawn, and take no memory", r.unseenBricks);
    if (reduction != Reduction::composite)
        line("leaps: %s", !scene.quality.skipping || reduction == Reduction::average
                              ? "none"
                              : "over bricks and cells whose values cannot change what a ray has");
    else if (scene.quality.skipping)
        line("cells of 8^3 voxels: %.1f %% can show something; rays leap over the rest, and over blocks of "
             "2^3 "
             "voxels in %zu of them",
             percent(r.occupiedCells, r.cells), r.refinedCells);
    if (r.engine == EngineKind::native && scene.quality.fetch == Fetch::hardware)
        line("fetch: exact; there is no hardware here that filters");
    if ((r.features & kFeatureCounting) || r.engine == EngineKind::native)
        line("work: %llu segments, %llu samples, %llu fetches, %llu dispatches, the longest %.0f ms",
             static_cast<unsigned long long>(r.work.segments),
             static_cast<unsigned long long>(r.work.samples), static_cast<unsigned long long>(r.work.fetches),
             static_cast<unsigned long long>(r.work.dispatches), r.work.longestDispatchMs);
    if (const auto& surfaces = r.surfaceLight)
        line("occlusion of surfaces: %d directions of %g mm from %zu places%s, %s, %.1f s; light of "
             "voxels has none",
             surfaces->rays, surfaces->radiusMm, surfaces->places,
             surfaces->alone > 0 ? (" and " + std::to_string(surfaces->alone) + " more samples").c_str() : "",
             formatBytes(surfaces->bytes).c_str(), surfaces->seconds);
    else if (const auto& occlusion = scene.lighting.occlusion)
        line("occlusion: %d rays of %g mm from each sample, kept beside the values%s", occlusion->rays,
             occlusion->radiusMm,
             r.light && r.light->emission ? ", and the light that tissue sends to it, red, green and blue"
                                          : "");
    if (r.light)
        line("light of voxels: %d of 16 bits a sample, %s beside the bricks, computed in %.1f s",
             r.light->channels, formatBytes(r.light->planeBytes).c_str(), r.light->seconds);
    if (r.light && r.light->maps > 0)
        line("shadows: %zu deep shadow maps of %d x %d rays, %s, within %.2g of the light but for %.2g %% of "
             "the rays "
             "(%.2g there)",
             r.light->maps, r.light->mapSize, r.light->mapSize, formatBytes(r.light->mapBytes).c_str(),
             static_cast<double>(ShadowQuality().error), 100 * r.light->shareOfMore,
             static_cast<double>(r.light->mapError));
    if (!r.light)
        line("light of voxels: none; no planes, no maps of shadows");
    char means[80] = "";
    if (r.stepOfMeans)
        std::snprintf(means, sizeof means, "%g in pixels that are the mean of eight rays or more, ",
                      *r.stepOfMeans);
    line("segments: %g voxels, %s%s", r.stepVoxels, means,
         integratorNames()[static_cast<std::size_t>(r.integrator)].c_str());
    if (r.pixels.asked == 1)
        line("pixels: one ray through the middle of each");
    else
        line("pixels: %.3g samples each in the mean, %d at most; %s", r.pixels.taken, r.pixels.most,
             scene.quality.pixels.filter == PixelFilter::box ? "the mean of the pixel's area"
                                                             : "a Gaussian of half a pixel's deviation");
    if (r.pixels.error)
        line("error of the samples' mean: rms %.2g, L*u*v* %.2g in the mean, %.2g at the 99th percentile "
             "(standard error, from how samples of a pixel differ)",
             r.pixels.error->rms, r.pixels.error->luvMean, r.pixels.error->luvP99);
    if (r.errors) {
        const PictureErrors& e = *r.errors;
        if (e.step)
            line("error of the step: rms %.2g, L*u*v* %.2g in the mean, %.2g at the 99th percentile, falling "
                 "at order "
                 "%.1f (estimated from %d pixels)",
                 e.step->error.rms, e.step->error.luvMean, e.step->error.luvP99, e.step->order, e.pixels);
        if (e.filtering)
            line("error of filtered fetches: rms %.2g, L*u*v* %.2g in the mean, %.2g at the 99th percentile",
                 e.filtering->rms, e.filtering->luvMean, e.filtering->luvP99);
    }
    if (r.measured)
        for (const std::string& text : describe(*r.measured))
            lines.push_back(text);
    if (reduction != Reduction::composite)
        return lines;
    if (const auto* const function = std::get_if<TransferFunction>(&scene.volumes.at(0).transferFunction);
        function && !function->gradientOpacity().isOne())
        line("opacity by gradient: %zu points, lengths per %s", function->gradientOpacity().points().size(),
             function->gradientOpacity().per() == GradientOpacity::Per::mm ? "mm" : "voxel");
    line("transfer function table: off by at most %.2g of the largest extinction, steps aside",
         r.tableRelativeError);
    line("ray termination: at most %.2g of a pixel's light is left out",
         scene.quality.terminationTransmittance);
    return lines;
}

} // namespace tessera

// render/renderer.cpp: see renderer.h.
#include "render/renderer.h"

#include "core/error.h"
#include "render/engines/gpu/check_march.h"
#include "render/engines/gpu/scene_march.h"
#include "render/engines/gpu/visibility_pass.h"
#include "render/engines/mirror/mirror.h"
#include "render/engines/reference/reference.h"
#include "render/plan/prepare.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What the next pass holds: the bricks that the first waiting rays need, as many as fit. The very first
/// ray's are always among them, so that every pass gets on.
std::vector<std::size_t> bricksToServe(const std::vector<std::uint32_t>& firstRay, const Selection& selection,
                                       std::size_t pages) {
    std::vector<std::size_t> order;
    for (std::size_t b = 0; b < firstRay.size(); ++b)
        if (firstRay[b] != UINT32_MAX)
            order.push_back(b);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(firstRay[a], a) < std::pair(firstRay[b], b);
    });
    std::array<std::size_t, kLevelCount + 1> counts{};
    std::size_t served = 0;
    for (; served < order.size(); ++served) {
        ++counts[selection.levels[order[served]]];
        if (pagesFor(counts) > pages)
            break;
    }
    TESSERA_CHECK(served > 0);
    order.resize(served);
    return order;
}

template <typename Real> Image toImage(const std::vector<glm::vec<4, Real>>& pixels, const glm::ivec2& size) {
    Image image(size);
    for (std::size_t i = 0; i < pixels.size(); ++i)
        image.pixels[i] = glm::vec4(pixels[i]);
    return image;
}

/// What eight bits can show.
constexpr double kDefaultStepError = 1.0 / 255;

void drawByMarch(const Scene& scene, PreparedScene& p, GlContext& context, Ledger& ram, Ledger& gpu,
                 const RenderOptions& options, Progress& progress, RenderResult& result) {
    progress.stage("loading bricks");
    const TextureLimits limits{context.max3dTextureSize(), context.maxTextureBytes()};
    const auto loading = Clock::now();
    Atlas atlas(p.info(), p.selection, p.chosen.atlasPages, limits, gpu, ram);
    if (p.chosen.chooser) {
        atlas.bricks.load(*p.cache, result.work);
        VisibilityPass pass(marchFeatures(p, false), p.info(), gpu);
        Work counting; // not the picture's
        p.chooseBySight(pass.count(visibilityRays(p.camera, p.info(), scene.imageSize, p.strides()),
                                   SceneField(p, atlas, gpu).source, p.optics, counting),
                        ram);
        atlas.bricks.adopt(p.selection);
    }
    result.features = marchFeatures(p, options.counting);
    if (p.chosen.atlasPages < pagesFor(p.selection.counts))
        result.features |= kFeaturePasses;
    const bool passes = (result.features & kFeaturePasses) != 0;
    const SceneField field(p, atlas, gpu);
    SceneMarch sceneMarch(result.features, p, gpu);
    result.features = sceneMarch.features();
    March& march = sceneMarch.march();
    if (!passes)
        atlas.bricks.load(*p.cache, result.work);
    result.secondsLoading = secondsSince(loading);
    const auto drawing = Clock::now();
    result.refinedCells = sceneMarch.refine(field.source);
    const auto runSliced = [&](March& rays, const MarchSlicing& slicing, Work& work) { // and how often
        int count = 1;
        for (; rays.run(field.source, slicing, work) > 0; ++count)
            atlas.bricks.serve(bricksToServe(rays.takeWanted(), p.selection, atlas.bricks.pages()), *p.cache,
                               work);
        return count;
    };
    const auto runSome = [&](March& rays, Work& work) { runSliced(rays, options.slicing, work); };
    CheckMarch check(march, result.features, p, runSome, ram);
    progress.stage("choosing the step");
    using Goal = CheckMarch::Goal;
    if (scene.quality.maxError.value_or(0) > 0)
        check.chooseStep({Goal::Measure::luvP99, *scene.quality.maxError - p.chosen.error.p99});
    else if (scene.quality.automaticStep && options.checking)
        check.chooseStep({Goal::Measure::rms, kDefaultStepError});
    result.features = (result.features & ~kIntegratorFeatures) | integratorFeatures(p.optics.integrator);
    progress.stage("drawing");
    MarchSlicing slicing = options.slicing;
    slicing.progress = progress.shares();
    result.passes = runSliced(march, slicing, result.work);
    result.image = march.image();
    result.secondsDrawing = secondsSince(drawing);
    const auto checking = Clock::now();
    if (options.checking) {
        progress.stage("estimating the picture's errors");
        result.errors = check.errorsOf(result.image, brightest(scene.shading));
        if (p.chosen.predicted)
            result.errors->levelsLuvP99 = p.chosen.error.p99;
    }
    result.secondsChecking = secondsSince(checking);
    if (!context.errors().empty())
        throw Error("OpenGL: " + context.errors().front());
}

void chooseBySightOnCpu(PreparedScene& p, int threads, Ledger& ram) {
    const VisibilityRays sight = visibilityRays(p.camera, p.info(), p.imageSize, p.strides());
    MirrorInput input = mirrorInput(p, false);
    input.strides = sight.strides;
    const glm::ivec2 size(sight.frame.imageSize);
    p.chooseBySight(mirrorSeen(input, static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y),
                               frameRays(cast<float>(sight.frame)), threads),
                    ram);
}

/// A first picture is drawn with: a sample of the coarse level a step, not two, and nothing tried or
/// estimated.
Scene firstScene(const Scene& scene) {
    Scene first = scene;
    first.quality.stepVoxels = std::min(2 * scene.quality.stepVoxels, 16.0);
    first.quality.automaticStep = false;
    first.quality.maxError.reset();
    return first;
}

/// Seconds that the picture itself takes, from how long the first one took: it takes as many more samples as
/// its level and step are finer. What is tried and estimated besides takes about a third of it again.
double secondsAfterFirst(const RenderResult& first, const Scene& scene) {
    const double samplesPerSample = (1 << first.level) * first.stepVoxels / scene.quality.stepVoxels;
    return 1.3 * samplesPerSample * 1e-3 * first.work.marchMs;
}

/// What the selection came to; after it is final.
void report(const PreparedScene& p, RenderResult& result) {
    result.level = p.selection.finest();
    result.integrator = p.optics.integrator;
    result.stepVoxels = p.quality.stepVoxels;
    result.bricksOfLevel = p.selection.counts;
    result.selectionPages = pagesFor(p.selection.counts);
    result.atlasPages = std::min(p.chosen.atlasPages, result.selectionPages);
    if (p.chosen.predicted)
        result.predictedError = p.chosen.error;
    result.residentBricks = p.selection.shownBricks();
    result.emptyBricks = p.selection.counts[Selection::kEmpty];
}

} // namespace

const char* name(Engine engine) {
    switch (engine) {
    case Engine::march:
        return "march";
    case Engine::mirror:
        return "mirror";
    case Engine::reference:
        return "reference";
    }
    return "?";
}

std::size_t pictureBytesPerPixel(Engine engine) {
    if (engine == Engine::reference) // its rays, their colours, and the picture made from them
        return std::max(kPictureBytesPerPixel, sizeof(ReferenceRay) + sizeof(glm::dvec4) + sizeof(glm::vec4));
    return kPictureBytesPerPixel;
}

RenderResult renderScene(const Scene& scene, const StoreReader& store, Ledger& ram, Ledger& gpu,
                         const RenderOptions& options) {
    RenderResult result;
    const auto start = Clock::now();
    std::optional<GlContext> context;
    TextureLimits limits;
    result.device = "CPU";
    if (options.engine == Engine::march) {
        context.emplace(options.device);
        limits = {context->max3dTextureSize(), context->maxTextureBytes()};
        result.device = context->renderer();
        result.glVersion = context->version();
    }
    Progress silent;
    Progress& progress = options.progress ? *options.progress : silent;
    progress.stage("reading statistics and choosing levels");
    const bool first = options.onFirstPicture && options.engine == Engine::march;
    const Scene coarse = first ? firstScene(scene) : scene;
    PreparedScene p =
        prepareScene(coarse, store, limits, ram, gpu, options.threads,
                     first ? LevelChoice::quick : options.levels, pictureBytesPerPixel(options.engine));
    if (first) {
        RenderResult quick;
        RenderOptions plain = options;
        plain.checking = false;
        drawByMarch(coarse, p, *context, ram, gpu, plain, progress, quick);
        report(p, quick);
        options.onFirstPicture(quick.image, secondsAfterFirst(quick, scene));
        quick = {};
        progress.stage("choosing levels");
        chooseAgain(p, scene, limits, ram, gpu, options.threads, options.levels);
    }
    result.camera = p.camera;
    result.tableRelativeError = p.table.relativeError;
    result.levelsOnPurpose = options.levels != LevelChoice::perBrick || options.engine == Engine::reference;
    result.cells = cellCount(p.statistics.cells);
    result.occupiedCells = scene.quality.skipping ? p.occupancy.occupiedCells() : result.cells;
    const SceneVolume& volume = scene.volumes.front();
    const ValueSummary values = summarise(p.statistics, p.info(), volume.unit);
    const auto* const preset = std::get_if<std::string>(&volume.transferFunction);
    result.takenAsHu = preset && *preset != "auto" && !values.isHu;
    result.lowest = values.lowest;
    result.highest = values.highest;
    result.secondsPreparing = secondsSince(start);

    if (options.engine == Engine::march) {
        drawByMarch(scene, p, *context, ram, gpu, options, progress, result);
        report(p, result);
        result.occupiedCells = scene.quality.skipping ? p.occupancy.occupiedCells() : result.cells;
        return result;
    }
    progress.stage("drawing");
    const auto drawing = Clock::now();
    const std::size_t pixels =
        static_cast<std::size_t>(scene.imageSize.x) * static_cast<std::size_t>(scene.imageSize.y);
    if (options.engine == Engine::mirror) {
        if (p.chosen.chooser)
            chooseBySightOnCpu(p, options.threads, ram);
        report(p, result);
        MirrorInput input = mirrorInput(p, scene.quality.skipping);
        input.progress = progress.shares();
        result.image = toImage(
            mirrorRays<float>(input, pixels, frameRays(cast<float>(p.frame)), options.threads, result.work),
            scene.imageSize);
    } else {
        report(p, result);
        result.level = 0;
        const ReferenceInput input{p.cache.get(), &p.info(), &p.function,    scene.shading,
                                   &p.statistics, 1,         scene.surfaces, progress.shares()};
        result.image = toImage(
            renderReference(input, referenceRays(p.camera, p.info(), scene.imageSize), options.threads),
            scene.imageSize);
    }
    result.secondsDrawing = secondsSince(drawing);
    return result;
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
    if (!r.predictedError && !r.levelsOnPurpose)
        line("level of detail: one level for all, because this budget of RAM cannot hold what choosing by "
             "brick needs");
    if (r.predictedError)
        line("level of detail: predicted error (L*u*v*) %.2g in the mean, %.2g at the 99th percentile",
             r.predictedError->mean, r.predictedError->p99);
    line("bricks: %zu resident, %zu (%.1f %%) show nothing and take no memory", r.residentBricks,
         r.emptyBricks, percent(r.emptyBricks, r.residentBricks + r.emptyBricks));
    if (scene.quality.skipping)
        line("cells of 8^3 voxels: %.1f %% can show something; rays leap over the rest, and over blocks of "
             "2^3 "
             "voxels in %zu of them",
             percent(r.occupiedCells, r.cells), r.refinedCells);
    if (r.features & kFeatureCounting)
        line("work: %llu segments, %llu samples, %llu fetches, %llu dispatches, the longest %.0f ms",
             static_cast<unsigned long long>(r.work.segments),
             static_cast<unsigned long long>(r.work.samples), static_cast<unsigned long long>(r.work.fetches),
             static_cast<unsigned long long>(r.work.dispatches), r.work.longestDispatchMs);
    line("segments: %g voxels, %s", r.stepVoxels,
         integratorNames()[static_cast<std::size_t>(r.integrator)].c_str());
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
    line("transfer function table: off by at most %.2g of the largest extinction, steps aside",
         r.tableRelativeError);
    line("ray termination: at most %.2g of a pixel's light is left out",
         scene.quality.terminationTransmittance);
    return lines;
}

} // namespace tessera

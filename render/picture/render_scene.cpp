// render/picture/render_scene.cpp: see render_scene.h.
#include "render/picture/render_scene.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "core/base/progress.h"
#include "render/backends/engine_maker.h"
#include "render/picture/draw_scene.h"
#include "render/picture/several_volumes.h"
#include "render/plan/fusion.h"
#include "render/plan/label_optics.h"
#include "render/plan/planner.h"
#include "render/plan/scene_rules.h"

#include <chrono>
#include <optional>

namespace tessera {

std::size_t pictureBytesPerPixel(EngineKind engine) {
    return engine == EngineKind::automatic ? kPictureBytesPerPixel : traitsOf(engine).bytesPerPixel;
}

std::size_t pictureBytesPerPixel(EngineKind engine, const PixelSampling& pixels) {
    return pictureBytesPerPixel(engine) + (pixels.samples == 1 ? 0 : AreaPicture::bytesPerPixel(pixels));
}

bool followsWays(const Scene& scene) {
    return scene.lighting.transport || reflects(scene);
}

std::string whyNotDrawn(const Scene& scene, EngineKind kind, const RenderOptions& options) {
    const EngineTraits& traits = traitsOf(kind);
    if (traits.declines)
        return traits.declines(scene, options);
    if (scene.lighting.transport && !traits.followsPaths)
        return "it follows no paths of light";
    if (reflects(scene) && !traits.followsPaths)
        return "it follows no rays that isosurfaces mirror or refract";
    if (const auto& occlusion = scene.lighting.occlusion;
        traits.exact && occlusion && occlusion->method == OcclusionMethod::histogram)
        return "its occlusion is along rays, not by histograms";
    if (traits.exact && scatters(scene.lighting))
        return "its light is not scattered to what is around";
    if (scene.volumes.size() == 1 || reductionOf(scene) != Reduction::composite)
        return {};
    if (!traits.fuses)
        return "it draws one volume";
    return traits.refuses ? traits.refuses(scene) : std::string();
}

namespace {

/// True if a scene needs another engine than the one that was made.
/// @param asked   whose engine becomes the other one
/// @param reason  is set then
/// Throws InputError if the engine was requested.
bool needsAnother(const Scene& scene, EngineKind made, RenderOptions& asked, std::string& reason) {
    const std::string why = whyNotDrawn(scene, made, asked);
    if (why.empty())
        return false;
    std::vector<std::string> names;
    for (const EngineTraits& traits : engineTraits())
        if (!traits.declines && (followsWays(scene) ? traits.followsPaths : traits.fuses) &&
            traits.kind != made)
            names.push_back(traits.name);
    if (asked.engine != EngineKind::automatic)
        throw badFile("--engine", joinNames(names) + " for this scene", name(made) + ": " + why);
    asked.engine = EngineKind::native;
    reason = why;
    return true;
}

/// Makes the renderer for a scene: where none is named one that can draw it.
/// @param reason  is set where that decides
void makeRenderer(const Scene& scene, RenderOptions asked, MemoryBudget& ram, MemoryBudget& gpu,
                  std::optional<RendererInstance>& made, std::string& reason) {
    made.emplace(asked, ram, gpu);
    if (!needsAnother(scene, made->kind, asked, reason))
        return;
    made.reset();
    made.emplace(asked, ram, gpu);
}

} // namespace

std::shared_ptr<Engine> makeEngine(const RenderOptions& options, MemoryBudget& ram, MemoryBudget& gpu) {
    struct Made {
        EngineMaker maker; // its device outlives the engine
        std::unique_ptr<Engine> engine;
        Made(const RenderOptions& o, MemoryBudget& ram, MemoryBudget& gpu)
            : maker(o.engine, o.device, o.threads), engine(maker.make(ram, gpu)) {}
    };
    const auto made = std::make_shared<Made>(options, ram, gpu);
    return {made, made->engine.get()};
}

RenderOptions optionsFor(const Scene& scene, Stores stores, const RenderOptions& options) {
    RenderOptions asked = options;
    const DrawnVolumes drawn = withLabelOptics(asDrawn(scene), stores);
    std::string reason;
    if (drawn.stores.size() > 1 || followsWays(drawn.scene)) { // the device goes before another is made
        const EngineMaker maker(options.engine, options.device, options.threads);
        needsAnother(drawn.scene, maker.kind(), asked, reason);
    }
    return asked;
}

std::shared_ptr<Engine> makeEngine(const Scene& scene, Stores stores, const RenderOptions& options,
                                   MemoryBudget& ram, MemoryBudget& gpu) {
    return makeEngine(optionsFor(scene, stores, options), ram, gpu);
}

RenderResult renderScene(const Scene& scene, const StoreReader& store, MemoryBudget& ram, MemoryBudget& gpu,
                         const RenderOptions& options) {
    const StoreReader* const stores[] = {&store};
    return renderScene(scene, stores, ram, gpu, options);
}

RenderResult renderScene(const Scene& given, Stores stores, MemoryBudget& ram, MemoryBudget& gpu,
                         const RenderOptions& options) {
    TESSERA_CHECK(stores.size() == given.volumes.size());
    const bool alone = stores.size() > 1 && reductionOf(asDrawn(given)) != Reduction::composite;
    TESSERA_CHECK(!alone || !options.tiles);
    if (alone)
        return drawVolumesAlone(given, stores, ram, gpu, options);
    const DrawnVolumes volumes = withLabelOptics(given, stores);
    const Scene scene = asDrawn(volumes.scene);
    const auto start = std::chrono::steady_clock::now();
    std::string reason;
    FrameContext context(ram, gpu, options.threads, options.progress);
    if (options.group) {
        TESSERA_CHECK(traitsOf(options.engine).drawsParts && !options.tiles && !options.onFirstPicture &&
                      options.verify == Verify::none && !options.kept);
        checkShared(scene);
        context.group = options.group;
    }
    std::optional<RendererInstance> made;
    makeRenderer(scene, options, ram, gpu, made, reason);
    const double making = secondsSince(start);
    Planner p;
    RenderResult result = drawScene(
        scene, p, *made, context, options, {},
        [&](const Scene& first, const TextureLimits& limits, LevelChoice levels, const PixelMemory& pixels) {
            return planScene(first, volumes.stores, limits, context, levels, pixels);
        });
    made->renderer->close(); // it reads the plan, which goes first
    if (!reason.empty())
        result.engineReason = reason;
    result.secondsPreparing += making;
    return result;
}

} // namespace tessera

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

#include <algorithm>
#include <chrono>

namespace tessera {

std::size_t pictureBytesPerPixel(EngineKind engine) {
    return engine == EngineKind::automatic ? kPictureBytesPerPixel : traitsOf(engine).bytesPerPixel;
}

std::size_t pictureBytesPerPixel(EngineKind engine, const PixelSampling& pixels) {
    return pictureBytesPerPixel(engine) + (pixels.samples == 1 ? 0 : AreaPicture::bytesPerPixel());
}

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

namespace {

/// The engine for a scene: one that composites all of its volumes.
/// @param reason  is set where that decides
RenderOptions optionsFor(const Scene& scene, const RenderOptions& asked, std::string& reason) {
    RenderOptions options = asked;
    if (scene.volumes.size() == 1)
        return options;
    std::vector<std::string> names;
    for (const EngineTraits& traits : engineTraits())
        if (traits.fuses)
            names.push_back(traits.name);
    if (asked.engine == EngineKind::automatic) {
        const auto& all = engineTraits();
        options.engine = std::find_if(all.begin(), all.end(), [](const EngineTraits& traits) {
                             return traits.fuses && traits.quick;
                         })->kind;
        reason = "the scene has several volumes, or functions of labels";
    } else if (!traitsOf(asked.engine).fuses) {
        throw badFile("--engine", joinNames(names) + " for several volumes", name(asked.engine));
    }
    return options;
}

} // namespace

RenderResult renderScene(const Scene& scene, const StoreReader& store, MemoryBudget& ram, MemoryBudget& gpu,
                         const RenderOptions& options) {
    const StoreReader* const stores[] = {&store};
    return renderScene(scene, stores, ram, gpu, options);
}

RenderResult renderScene(const Scene& given, Stores stores, MemoryBudget& ram, MemoryBudget& gpu,
                         const RenderOptions& asked) {
    TESSERA_CHECK(stores.size() == given.volumes.size());
    if (stores.size() > 1 && reductionOf(asDrawn(given)) != Reduction::composite)
        return drawVolumesAlone(given, stores, ram, gpu, asked);
    const DrawnVolumes volumes = withLabelOptics(given, stores);
    const Scene scene = asDrawn(volumes.scene);
    const auto start = std::chrono::steady_clock::now();
    std::string reason;
    const RenderOptions options = optionsFor(scene, asked, reason);
    const FrameContext context(ram, gpu, options.threads, options.progress);
    const RendererInstance made(options, ram, gpu);
    const double making = secondsSince(start);
    Planner p;
    RenderResult result = drawScene(
        scene, p, made, context, options, {},
        [&](const Scene& first, const TextureLimits& limits, LevelChoice levels, std::size_t bytesPerPixel) {
            return planScene(first, volumes.stores, limits, context, levels, bytesPerPixel);
        });
    made.renderer->close(); // it reads the plan, which goes first
    if (!reason.empty())
        result.engineReason = reason;
    result.secondsPreparing += making;
    return result;
}

} // namespace tessera

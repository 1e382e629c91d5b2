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

#include <chrono>
#include <optional>

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

/// Why an engine cannot draw a scene; empty: it can.
std::string refusalOf(const Scene& scene, EngineKind kind) {
    const EngineTraits& traits = traitsOf(kind);
    if (scene.volumes.size() == 1)
        return {};
    if (!traits.fuses)
        return "it draws one volume";
    return traits.refuses ? traits.refuses(scene) : std::string();
}

/// Makes the renderer for a scene: where none is named one that can draw it.
/// @param reason  is set where that decides
void makeRenderer(const Scene& scene, const RenderOptions& asked, MemoryBudget& ram, MemoryBudget& gpu,
                  std::optional<RendererInstance>& made, std::string& reason) {
    made.emplace(asked, ram, gpu);
    const std::string why = refusalOf(scene, made->kind);
    if (why.empty())
        return;
    std::vector<std::string> names;
    for (const EngineTraits& traits : engineTraits())
        if (traits.fuses && traits.kind != made->kind)
            names.push_back(traits.name);
    if (asked.engine != EngineKind::automatic)
        throw badFile("--engine", joinNames(names) + " for this scene", name(made->kind) + ": " + why);
    made.reset();
    RenderOptions options = asked;
    options.engine = EngineKind::native;
    made.emplace(options, ram, gpu);
    reason = why;
}

} // namespace

RenderResult renderScene(const Scene& scene, const StoreReader& store, MemoryBudget& ram, MemoryBudget& gpu,
                         const RenderOptions& options) {
    const StoreReader* const stores[] = {&store};
    return renderScene(scene, stores, ram, gpu, options);
}

RenderResult renderScene(const Scene& given, Stores stores, MemoryBudget& ram, MemoryBudget& gpu,
                         const RenderOptions& options) {
    TESSERA_CHECK(stores.size() == given.volumes.size());
    if (stores.size() > 1 && reductionOf(asDrawn(given)) != Reduction::composite)
        return drawVolumesAlone(given, stores, ram, gpu, options);
    const DrawnVolumes volumes = withLabelOptics(given, stores);
    const Scene scene = asDrawn(volumes.scene);
    const auto start = std::chrono::steady_clock::now();
    std::string reason;
    const FrameContext context(ram, gpu, options.threads, options.progress);
    std::optional<RendererInstance> made;
    makeRenderer(scene, options, ram, gpu, made, reason);
    const double making = secondsSince(start);
    Planner p;
    RenderResult result = drawScene(
        scene, p, *made, context, options, {},
        [&](const Scene& first, const TextureLimits& limits, LevelChoice levels, std::size_t bytesPerPixel) {
            return planScene(first, volumes.stores, limits, context, levels, bytesPerPixel);
        });
    made->renderer->close(); // it reads the plan, which goes first
    if (!reason.empty())
        result.engineReason = reason;
    result.secondsPreparing += making;
    return result;
}

} // namespace tessera

// render/picture/render_scene.cpp: see render_scene.h.
#include "render/picture/render_scene.h"

#include "core/base/progress.h"
#include "render/backends/engine_maker.h"
#include "render/picture/draw_scene.h"
#include "render/plan/planner.h"

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

RenderResult renderScene(const Scene& given, const StoreReader& store, MemoryBudget& ram, MemoryBudget& gpu,
                         const RenderOptions& options) {
    const Scene scene = asDrawn(given);
    const auto start = std::chrono::steady_clock::now();
    const FrameContext context(ram, gpu, options.threads, options.progress);
    const RendererInstance made(options, ram, gpu);
    const double making = secondsSince(start);
    Planner p;
    RenderResult result = drawScene(
        scene, p, made, context, options, {},
        [&](const Scene& first, const TextureLimits& limits, LevelChoice levels, std::size_t bytesPerPixel) {
            return planScene(first, store, limits, context, levels, bytesPerPixel);
        });
    made.renderer->close(); // it reads the plan, which goes first
    result.secondsPreparing += making;
    return result;
}

} // namespace tessera

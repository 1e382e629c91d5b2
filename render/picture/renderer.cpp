// render/picture/renderer.cpp: see renderer.h.
#include "render/picture/renderer.h"
#include "core/base/stopwatch.h"

#include "render/picture/draw_scene.h"

#include <chrono>

namespace tessera {

std::size_t pictureBytesPerPixel(EngineKind engine) {
    return engine == EngineKind::automatic ? kPictureBytesPerPixel : traitsOf(engine).bytesPerPixel;
}

std::size_t pictureBytesPerPixel(EngineKind engine, const PixelSampling& pixels) {
    return pictureBytesPerPixel(engine) + (pixels.samples == 1 ? 0 : AreaPicture::bytesPerPixel());
}

std::shared_ptr<Engine> makeEngine(const RenderOptions& options, MemoryBudget& ram, MemoryBudget& gpu) {
    auto made = std::make_shared<EngineInstance>(options, ram, gpu);
    Engine* const engine = made->engine.get();
    return {std::move(made), engine};
}

RenderResult renderScene(const Scene& given, const StoreReader& store, MemoryBudget& ram, MemoryBudget& gpu,
                         const RenderOptions& options) {
    const Scene scene = asDrawn(given);
    const auto start = std::chrono::steady_clock::now();
    const FrameContext context(ram, gpu, options.threads, options.progress);
    const EngineInstance made(options, ram, gpu);
    const double making = secondsSince(start);
    ScenePlan p;
    RenderResult result = drawScene(
        scene, p, made, context, options, {},
        [&](const Scene& first, const TextureLimits& limits, LevelChoice levels, std::size_t bytesPerPixel) {
            return planScene(first, store, limits, context, levels, bytesPerPixel);
        });
    made.engine->close(); // it reads the plan, which goes first
    result.secondsPreparing += making;
    return result;
}

} // namespace tessera

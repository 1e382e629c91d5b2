// viewer/cli/batch/row_shares.cpp: see row_shares.h.
#include "viewer/cli/batch/row_shares.h"

#include "core/base/budget.h"
#include "core/base/budget_error.h"
#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/backends/engine_maker.h"
#include "render/picture/render_scene.h" // pictureBytesPerPixel
#include "viewer/cli/render/run_render.h"

#include <algorithm>
#include <string>

namespace tessera {
namespace {

/// True if pictures are drawn by one device, which rows would wait for.
bool drawsOnDevice(const BatchArguments& arguments) {
    RenderArguments render;
    render.engine = arguments.engine;
    GlDeviceChoice device;
    device.text = arguments.device;
    return traitsOf(EngineMaker(engineOf(render), device, 1).kind()).onContext;
}

} // namespace

RowShares sharesOf(const BatchArguments& arguments, const BatchRows& rows, const Scene& scene,
                   std::size_t ramBytes, std::size_t gpuBytes, const CommonOptions& common) {
    constexpr std::size_t kLeastBytes = std::size_t{8} << 20;   // of a row beside its picture
    constexpr std::size_t kUsualBytes = std::size_t{192} << 20; // with bricks of a volume
    RenderArguments render;
    render.engine = arguments.engine;
    const EngineKind engine = engineOf(render);
    const glm::ivec2 size = rows.largestSize();
    const std::size_t ofPicture =
        static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
        (pictureBytesPerPixel(engine, scene.quality.pixels) + kPictureBytesPerPixel);
    const int processors = defaultThreads();
    RowShares shares;
    if (arguments.jobs > 0 && !arguments.dryRun) { // which looks at them in their order
        shares.jobs = arguments.jobs;
        const std::size_t least = static_cast<std::size_t>(shares.jobs) * (ofPicture + kLeastBytes);
        if (ramBytes < least)
            throw OverBudget("--ram: " + std::to_string(shares.jobs) + " rows at once, of " +
                             std::to_string(size.x) + " x " + std::to_string(size.y) +
                             " pixels, need at least " + formatBytes(least) + ", but the budget has " +
                             formatBytes(ramBytes) + " for them; fewer --jobs need less");
    } else if (!arguments.dryRun && !drawsOnDevice(arguments)) {
        const std::size_t room = ramBytes / (ofPicture + kUsualBytes);
        shares.jobs = static_cast<int>(
            std::clamp<std::size_t>(room, 1, static_cast<std::size_t>(std::max(1, processors))));
    }
    shares.jobs = static_cast<int>(
        std::min<std::size_t>(static_cast<std::size_t>(shares.jobs), std::max<std::size_t>(1, rows.size())));
    if (shares.jobs > 1)
        shares.threads = std::max(1, processors / shares.jobs);
    shares.ram = ramBytes / static_cast<std::size_t>(shares.jobs);
    shares.gpu = gpuBytes / static_cast<std::size_t>(shares.jobs);
    common.detail(std::to_string(shares.jobs) + (shares.jobs == 1 ? " row" : " rows") +
                  " at once, each with " + formatBytes(shares.ram) + " of --ram, " + formatBytes(shares.gpu) +
                  " of --gpu-memory and " + std::to_string(shares.threads > 0 ? shares.threads : processors) +
                  " threads");
    return shares;
}

} // namespace tessera

// viewer/session/still.cpp: see still.h.
#include "viewer/session/still.h"

#include "core/base/error.h"
#include "viewer/cli/manifest/manifest.h"
#include "viewer/cli/options/options.h" // formatNumber

#include <nlohmann/json.hpp>

namespace tessera {
namespace {

std::string measuredText(const RenderResult& result) {
    if (!result.measured)
        return {};
    const PictureMeasurement& m = *result.measured;
    if (!m.whyNot.empty())
        return "not measured: " + m.whyNot;
    if (!m.all.luvP99)
        return {};
    const auto& e = *m.all.luvP99;
    return "99 of 100 pixels err by at most " + formatNumber(e.value, 2) + " (" + formatNumber(e.low, 2) +
           " to " + formatNumber(e.high, 2) + ", L*u*v*)";
}

FinishedStill draw(const Scene& scene, std::uint64_t asked, const StoreReader& store, MemoryBudget& ram,
                   MemoryBudget& gpu, const RenderOptions& options) {
    FinishedStill finished;
    RenderResult result = renderScene(scene, store, ram, gpu, options);
    auto picture = std::make_shared<ShownPicture>();
    picture->stage = Stage::still;
    picture->camera = result.camera;
    picture->asked = asked;
    picture->drawingMs = 1e3 * (result.secondsPreparing + result.secondsLoading + result.secondsDrawing);
    picture->manifest = makeManifest(scene, store, result, ram, gpu)
                            .dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    picture->background = scene.background;
    finished.measured = measuredText(result);
    picture->image = std::move(result.image);
    finished.picture = std::move(picture);
    return finished;
}

} // namespace

Still::Still(const Scene& scene, std::uint64_t asked, const StoreReader& store, MemoryBudget& ram,
             MemoryBudget& gpu, const RenderOptions& options, std::function<void()> ended)
    : result_(std::async(std::launch::async,
                         [this, scene, asked, &store, &ram, &gpu, options, ended = std::move(ended)] {
                             FinishedStill finished;
                             try {
                                 const Cancellation asks(&calledOff_);
                                 finished = draw(scene, asked, store, ram, gpu, options);
                             } catch (const Cancelled&) {
                                 finished = {};
                             } catch (const std::exception& e) {
                                 finished.problem = e.what();
                             }
                             ended();
                             return finished;
                         })) {}

Still::~Still() {
    calledOff_ = true;
    if (result_.valid())
        result_.wait();
}

} // namespace tessera

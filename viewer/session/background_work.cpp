// viewer/session/background_work.cpp: see background_work.h.
#include "viewer/session/background_work.h"

#include "bricking/analysis/lumen/centreline.h"
#include "bricking/analysis/lumen/wall_coverage.h"
#include "core/animation/path.h"
#include "core/base/error.h"
#include "viewer/cli/manifest/manifest.h"
#include "viewer/cli/options/options.h" // formatNumber

#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

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

/// @param scene  with the camera of the picture
std::shared_ptr<ShownPicture> roundOf(const Scene& scene, Image image, const SamplesSeen& samples,
                                      double ms) {
    auto picture = std::make_shared<ShownPicture>();
    picture->stage = Stage::round;
    picture->camera = std::get<Camera>(scene.camera);
    picture->drawingMs = ms;
    picture->background = scene.background;
    picture->samples = samples;
    picture->image = std::move(image);
    return picture;
}

FinishedStill draw(const Scene& scene, std::uint64_t asked, Stores stores, MemoryBudget& ram,
                   MemoryBudget& gpu, RenderOptions options, const Still::Round& round) {
    FinishedStill finished;
    const auto began = std::chrono::steady_clock::now();
    if (round)
        options.onRound = [&](Image image, int samples, std::optional<double> noise) {
            round(roundOf(scene, std::move(image), {samples, scene.quality.pixels.samples, noise},
                          1e3 * secondsSince(began)));
        };
    RenderResult result = renderScene(scene, stores, ram, gpu, options);
    auto picture = std::make_shared<ShownPicture>();
    picture->stage = Stage::still;
    picture->camera = result.camera;
    picture->asked = asked;
    picture->drawingMs = 1e3 * (result.secondsPreparing + result.secondsLoading + result.secondsDrawing);
    nlohmann::json manifest = makeManifest(scene, stores, result, ram, gpu);
    std::vector<SourceChoice> sources;
    for (const SceneVolume& volume : scene.volumes)
        sources.push_back(volume.source);
    if (nlohmann::json chosen = sourcesJson(sources); !chosen.empty())
        manifest["options"]["sources"] = std::move(chosen);
    picture->manifest = manifest.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    picture->background = scene.background;
    if (scene.lighting.transport && reductionOf(scene) == Reduction::composite)
        picture->samples =
            SamplesSeen{result.pixels.most, scene.quality.pixels.samples,
                        result.pixels.error ? std::optional(result.pixels.error->rms) : std::nullopt};
    finished.measured = measuredText(result);
    picture->image = std::move(result.image);
    finished.picture = std::move(picture);
    return finished;
}

} // namespace

Still::Still(const Scene& scene, std::uint64_t asked, std::vector<const StoreReader*> stores,
             MemoryBudget& ram, MemoryBudget& gpu, const RenderOptions& options, std::function<void()> ended,
             Round round)
    : result_(std::async(std::launch::async, [this, scene, asked, stores = std::move(stores), &ram, &gpu,
                                              options, round = std::move(round), ended = std::move(ended)] {
          FinishedStill finished;
          try {
              const Cancellation asks(&calledOff_);
              finished = draw(scene, asked, stores, ram, gpu, options, round);
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

namespace {

std::string aboutText(const Centrelines& found, const VolumeInfo& info) {
    std::string text = linesText(found.lines) + "; " + lumenText(found, info.unit);
    if (!found.bridges.empty())
        text += "; gaps bridged: " + std::to_string(found.bridges.size());
    return text;
}

LineState find(const LineWish& wish, const StoreReader& store, MemoryBudget& ram, Progress& progress,
               int threads) {
    CentrelineRequest request;
    for (std::size_t i = 0; i < wish.places.size(); ++i)
        request.seeds.push_back({wish.places[i], "place " + std::to_string(i + 1),
                                 i > 0 && i + 1 < wish.places.size()}); // those on the way bridge gaps
    request.threshold = wish.threshold;
    request.tree = wish.tree;
    const Centrelines found = findCentrelines(store, request, ram, progress, threads);
    auto path = std::make_shared<Path>();
    path->volume = {store.contentHash(), store.info().extentVoxels};
    path->lumen = found.lumen;
    path->lines = found.lines;
    path->flight.emplace();
    checkPath(*path, "the line");
    LineState state;
    state.path = std::move(path);
    state.about = aboutText(found, store.info());
    return state;
}

constexpr double kCoverageStepMm = 1;

LineState lookAlong(const LineWish& wish, const StoreReader& store, MemoryBudget& ram, Progress& progress,
                    int threads) {
    const Path& path = *wish.seenAlong;
    CoverageRequest request;
    request.lines = path.lines;
    request.flight = path.flight.value_or(Flight{});
    request.lumen = path.lumen.value_or(Lumen{});
    request.cameras = flightCameras(path, kCoverageStepMm, wish.bothWays);
    request.aspect = wish.aspect;
    LineState state;
    state.coverage =
        std::make_shared<WallCoverage>(measureWallCoverage(store, request, ram, progress, threads));
    state.about = coverageText(*state.coverage, request.smallestPatchMm2);
    return state;
}

} // namespace

LineFinder::LineFinder(const LineWish& wish, const StoreReader& store, MemoryBudget& ram, int threads,
                       std::function<void()> ended)
    : progress_(std::make_shared<Progress>(Verbosity::quiet, true)),
      result_(std::async(std::launch::async, [this, wish, &store, &ram, threads, ended = std::move(ended)] {
          LineState state;
          try {
              const Cancellation asks(&calledOff_);
              state = (wish.seenAlong ? lookAlong : find)(wish, store, ram, *progress_, threads);
          } catch (const Cancelled&) {
              state = {};
          } catch (const std::exception& e) {
              state.problem = e.what();
          }
          ended();
          return state;
      })) {}

LineFinder::~LineFinder() {
    calledOff_ = true;
    if (result_.valid())
        result_.wait();
}

} // namespace tessera

// viewer/cli/render/phase_film.cpp: see phase_film.h.
#include "viewer/cli/render/phase_film.h"

#include "bricking/statistics/statistics.h"
#include "core/base/error.h"
#include "core/scene/mode.h"
#include "render/plan/framing.h"
#include "render/plan/fusion.h"
#include "render/plan/planner.h"
#include "render/plan/turn_fit.h"
#include "viewer/cli/input/phase_input.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

namespace tessera {
namespace {

/// The camera that shows what any of the phases does.
Camera cameraOfPhases(const RenderTask& task, const Scene& scene) {
    const auto& view = std::get<FittedView>(scene.camera);
    const bool ofPlane = scene.mode == Mode::slice && !view.named;
    if (ofPlane || view.fit != Fit::shown)
        return planView(scene, task.store, task.ram, task.options.threads).view.camera;
    Scene placed = scene;
    placed.camera = Camera{}; // nothing is fitted twice
    std::optional<ViewFit> all;
    for (const std::filesystem::path& path : task.phases->stores) {
        const std::unique_ptr<StoreReader> store = task.open(path);
        const Planner p = planView(placed, *store, task.ram, task.options.threads);
        const Layer& layer = p.layer();
        const ViewFit fit =
            shownFit(view, layer.voxels(), layer.statistics, layer.shownTable(), p.view.part, scene.imageSize,
                     *p.ram, task.options.threads, layer.labelBricks.get(), p.view.meshes);
        if (fit.empty())
            continue;
        if (all)
            all->add(fit);
        else
            all = fit;
    }
    Camera camera =
        all ? all->camera() : fitCamera(task.store.info(), axesOf(view), view.projection, scene.imageSize);
    if (view.mmPerPixel > 0)
        camera.parallelScale = parallelScaleOf(view.mmPerPixel, scene.imageSize);
    return camera;
}

/// The camera of a turn that holds what any of the phases shows.
Camera turnOfPhases(const RenderTask& task, const Scene& scene) {
    TurnFit all;
    for (const std::filesystem::path& path : task.phases->stores) {
        const std::unique_ptr<StoreReader> store = task.open(path);
        const StoreReader* const one = store.get();
        all.add(turnFit(scene, Stores(&one, 1), task.ram, task.options.threads));
    }
    return turningCamera(scene, std::move(all));
}

} // namespace

namespace {

/// Ranges and histograms of all values, or of all but fill values.
ValueSummary rangeOfAll(const std::vector<ValueSummary>& values) {
    ValueSummary all = values.front();
    for (const ValueSummary& one : values) {
        all.lowest = std::min(all.lowest, one.lowest);
        all.highest = std::max(all.highest, one.highest);
        all.isHu = all.isHu && one.isHu;
    }
    const std::size_t bins = all.histogram.size();
    std::fill(all.histogram.begin(), all.histogram.end(), 0);
    const double width = all.highest - all.lowest;
    for (const ValueSummary& one : values)
        for (std::size_t n = 0; n < one.histogram.size() && bins > 0; ++n) {
            const double middle = one.lowest + (one.highest - one.lowest) * (static_cast<double>(n) + 0.5) /
                                                   static_cast<double>(one.histogram.size());
            const double at = width > 0 ? (middle - all.lowest) / width * static_cast<double>(bins) : 0;
            all.histogram[std::min(bins - 1, static_cast<std::size_t>(std::max(0.0, at)))] +=
                one.histogram[n];
        }
    return all;
}

/// The fill values of all phases, with their shares of all voxels.
std::vector<FillValue> fillsOfAll(const std::vector<ValueSummary>& values) {
    std::vector<FillValue> fills;
    for (const ValueSummary& one : values)
        for (const FillValue& fill : one.fills) {
            const double share = fill.share / static_cast<double>(values.size());
            const auto same = std::ranges::find(fills, fill.value, &FillValue::value);
            if (same == fills.end())
                fills.push_back({fill.value, share});
            else
                same->share += share;
        }
    return fills;
}

} // namespace

ValueSummary together(const std::vector<ValueSummary>& values) {
    ValueSummary all = rangeOfAll(values);
    all.fills = fillsOfAll(values);
    all.measured = {};
    if (all.fills.empty())
        return all;
    std::vector<ValueSummary> measured;
    std::ranges::transform(values, std::back_inserter(measured), withoutFills);
    ValueSummary rest = rangeOfAll(measured);
    all.measured = {rest.lowest, rest.highest, std::move(rest.histogram)};
    return all;
}

Path stillPath(const Camera& camera, std::size_t frames, double framesPerSecond) {
    if (frames > Path::kMostKeyframes)
        throw badFile("--phase all", "at most " + std::to_string(Path::kMostKeyframes) + " phases",
                      std::to_string(frames));
    Path path;
    path.framesPerSecond = framesPerSecond;
    for (std::size_t n = 0; n < frames; ++n) {
        Keyframe key;
        key.timeS = static_cast<double>(n) / framesPerSecond;
        key.easing = Easing::linear;
        key.camera = camera;
        path.keyframes.push_back(key);
    }
    return path;
}

Path withFunctions(Path path, const ValueSummary& values) {
    for (Keyframe& key : path.keyframes)
        if (key.transferFunction)
            if (const auto* const name = std::get_if<std::string>(&*key.transferFunction))
                key.transferFunction = presetFunction(*name, values);
    return path;
}

SharedByPhases sharedByPhases(const RenderTask& task) {
    SharedByPhases shared{task.scene, {}, {}};
    Scene& scene = shared.scene;
    const Reduction reduction = reductionOf(scene);
    const bool isOpen = !std::holds_alternative<GreyWindow>(scene.window);
    if (reduction == Reduction::sum && scene.mode != Mode::absorption && isOpen)
        throw badFile("--window", "CENTRE,WIDTH of mode " + nameOf(scene.mode) + " with --phase all", "auto");
    std::vector<ValueSummary> values;
    for (const std::filesystem::path& path : task.phases->stores) {
        const std::unique_ptr<StoreReader> store = task.open(path);
        const Statistics statistics = loadStatistics(*store, task.ram, task.options.threads);
        values.push_back(summarise(statistics, store->info(), scene.volumes.front().unit));
        shared.hashes.push_back(store->contentHash());
    }
    const ValueSummary all = shared.values = together(values);
    if (const auto* const name = std::get_if<std::string>(&scene.volumes.front().transferFunction))
        scene.volumes.front().transferFunction = presetFunction(*name, all);
    if (isOpen && reduction != Reduction::composite && reduction != Reduction::sum)
        scene.window = windowOf(scene.window, all, scene.mode);
    if (!std::holds_alternative<FittedView>(scene.camera) || !task.arguments.path.empty())
        return shared;
    if (!task.arguments.turn)
        scene.camera = cameraOfPhases(task, scene);
    else if (scene.mode != Mode::slice) // which is refused
        scene.camera = turnOfPhases(task, scene);
    return shared;
}

} // namespace tessera

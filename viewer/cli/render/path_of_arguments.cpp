// viewer/cli/render/path_of_arguments.cpp: see path_of_arguments.h.
#include "viewer/cli/render/path_of_arguments.h"

#include "core/animation/film.h"
#include "core/animation/flight.h"
#include "core/base/error.h"
#include "render/plan/framing.h"
#include "render/plan/planner.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace tessera {

namespace {

void checkTurnOptions(const RenderArguments& a) {
    if (!a.path.empty())
        throw badFile("--turn", "--turn or --path, which has the cameras", "both");
    for (const auto& [said, option] : {std::pair{a.speed > 0, "--speed"},
                                       {a.unfold, "--unfold"},
                                       {a.mayLeak, "--may-leak"},
                                       {!a.first.empty(), "--first"},
                                       {a.scaleBar, "--scale-bar"},
                                       {a.explain, "--explain"}})
        if (said)
            throw badFile(option, std::string("no ") + option + " beside --turn", option);
    if (!a.frames.empty() && a.seconds > 0)
        throw badFile("--frames", "--frames or --seconds, which makes as many as --fps asks", "both");
}

/// Frames of a turn: a count, or as many as its seconds have.
std::size_t turnFrames(const RenderArguments& a, double framesPerSecond) {
    constexpr std::size_t kFrames = 120;
    if (a.seconds > 0)
        return static_cast<std::size_t>(std::max(2.0, std::round(a.seconds * framesPerSecond)));
    if (a.frames.empty())
        return kFrames;
    if (a.frames.size() > 6 || a.frames.find_first_not_of("0123456789") != std::string::npos)
        throw badFile("--frames", "beside --turn how many", "\"" + a.frames.substr(0, 40) + "\"");
    return static_cast<std::size_t>(std::stoul(a.frames));
}

} // namespace

void checkFilmOptions(const RenderArguments& a) {
    const bool film = !a.path.empty();
    if (a.turn) {
        checkTurnOptions(a);
        return;
    }
    for (const auto& [said, option] : {std::pair{!a.frames.empty(), "--frames"},
                                       {a.framesPerSecond > 0, "--fps"},
                                       {a.speed > 0, "--speed"},
                                       {a.seconds > 0, "--seconds"}})
        if (said && !film)
            throw badFile(option, "--path or --turn with it: it is for films", "none");
    if (a.unfold && !film)
        throw badFile("--unfold", "--path with it, which has the line", "none");
    if (a.mayLeak && !a.unfold)
        throw badFile("--may-leak", "--unfold with it", "none");
    if (!film)
        return;
    for (const auto& [said, option] : {std::pair{!a.frames.empty(), "--frames"},
                                       {a.framesPerSecond > 0, "--fps"},
                                       {a.speed > 0, "--speed"},
                                       {a.seconds > 0, "--seconds"},
                                       {!a.keys.textOf("--max-error").empty(), "--max-error"},
                                       {!a.verify.empty(), "--verify"}})
        if (said && a.unfold)
            throw badFile(option, std::string("no ") + option + " with --unfold, which is one picture",
                          option);
    for (const auto& [said, option] : {std::pair{!a.view.empty(), "--view"},
                                       {!a.fit.empty(), "--fit"},
                                       {!a.projection.empty(), "--projection"},
                                       {a.mmPerPixel > 0, "--mm-per-pixel"},
                                       {!a.first.empty(), "--first"},
                                       {a.scaleBar, "--scale-bar"},
                                       {a.explain, "--explain"}})
        if (said)
            throw badFile(option, std::string("no ") + option + " with --path, which has the cameras",
                          option);
    if (a.speed > 0 && a.seconds > 0)
        throw badFile("--speed", "--speed or --seconds, which chooses a speed", "both");
}

Path pathOf(const RenderTask& task) {
    const RenderArguments& a = task.arguments;
    Path path = loadPath(a.path);
    const bool cameras = std::any_of(path.keyframes.begin(), path.keyframes.end(),
                                     [](const Keyframe& key) { return key.camera.has_value(); });
    if (!path.flight && !cameras && !path.lines.empty())
        path.flight = Flight{}; // a line alone is flown
    if (path.volume && path.volume->contentHash != task.store.contentHash())
        task.common.note(a.path + ": its lines were made in another volume (" +
                         formatExtent(path.volume->extentVoxels) + " voxels; this one has " +
                         formatExtent(task.store.info().extentVoxels) + ")");
    if (a.framesPerSecond > 0)
        path.framesPerSecond = a.framesPerSecond;
    if (a.speed > 0 || a.seconds > 0) {
        if (!path.flight)
            throw badFile(a.speed > 0 ? "--speed" : "--seconds", "a path with a line that is flown",
                          "one of keyframes");
        path.flight->speedMmPerS =
            a.speed > 0 ? a.speed : FlightCurve(path.lines, *path.flight).lengthMm() / a.seconds;
    }
    return path;
}

Path turnOf(const RenderTask& task) {
    const RenderArguments& a = task.arguments;
    const Scene& scene = task.scene;
    const double framesPerSecond = a.framesPerSecond > 0 ? a.framesPerSecond : Path().framesPerSecond;
    const std::size_t frames = turnFrames(a, framesPerSecond);
    const auto* const view = std::get_if<FittedView>(&scene.camera);
    if (!view)
        return turntable(std::get<Camera>(scene.camera), *a.turn, frames, framesPerSecond);
    if (scene.mode == Mode::slice)
        throw badFile("--turn", "a volume to turn around", "a slice, which is seen along its normal");
    const Planner plan = planView(scene, task.store, task.ram, task.options.threads);
    Camera camera = turningCamera(*view, task.store, plan.layer().statistics, plan.layer().table,
                                  plan.view.part, scene.imageSize, task.ram, task.options.threads);
    if (view->mmPerPixel > 0)
        camera.parallelScale = parallelScaleOf(view->mmPerPixel, scene.imageSize);
    return turntable(camera, *a.turn, frames, framesPerSecond);
}

} // namespace tessera

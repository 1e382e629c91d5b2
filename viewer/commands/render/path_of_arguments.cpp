// viewer/commands/render/path_of_arguments.cpp: see path_of_arguments.h.
#include "viewer/commands/render/path_of_arguments.h"

#include "core/error.h"
#include "core/flight.h"

#include <algorithm>
#include <utility>

namespace tessera {

void checkFilmOptions(const RenderArguments& a) {
    const bool film = !a.path.empty();
    for (const auto& [said, option] : {std::pair{!a.frames.empty(), "--frames"},
                                       {a.framesPerSecond > 0, "--fps"},
                                       {a.speed > 0, "--speed"},
                                       {a.seconds > 0, "--seconds"}})
        if (said && !film)
            throw badFile(option, "--path beside it: it is of films", "none");
    if (a.unfold && !film)
        throw badFile("--unfold", "--path beside it, which has the line", "none");
    if (a.mayLeak && !a.unfold)
        throw badFile("--may-leak", "--unfold beside it", "none");
    if (!film)
        return;
    for (const auto& [said, option] : {std::pair{!a.frames.empty(), "--frames"},
                                       {a.framesPerSecond > 0, "--fps"},
                                       {a.speed > 0, "--speed"},
                                       {a.seconds > 0, "--seconds"},
                                       {a.maxError >= 0, "--max-error"},
                                       {!a.verify.empty(), "--verify"}})
        if (said && a.unfold)
            throw badFile(option, std::string("no ") + option + " beside --unfold, which is one picture",
                          option);
    for (const auto& [said, option] : {std::pair{!a.view.empty(), "--view"},
                                       {!a.fit.empty(), "--fit"},
                                       {!a.projection.empty(), "--projection"},
                                       {!a.first.empty(), "--first"},
                                       {a.explain, "--explain"}})
        if (said)
            throw badFile(option, std::string("no ") + option + " beside --path, which has the cameras",
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

} // namespace tessera

// viewer/cli/render/wall_along_path.cpp: see wall_along_path.h.
#include "viewer/cli/render/wall_along_path.h"

#include "core/animation/flight.h"
#include "core/base/error.h"
#include "core/base/output_file.h"
#include "render/picture/unfolded.h"
#include "viewer/cli/manifest/manifest.h"
#include "viewer/cli/render/path_of_arguments.h"
#include "viewer/cli/render/picture_files.h"
#include "viewer/cli/render/picture_notes.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

namespace tessera {
namespace {

/// Rows along the flight's line. Without a given size the width is the scene's, and pixels are square on a
/// wall at the line's mean distance from it.
std::vector<UnfoldedRow> rowsOf(const Path& path, const std::string& where, bool sized, Scene& scene) {
    if (!path.flight)
        throw badFile(where, "a path with lines", "one of keyframes");
    Flight flight = *path.flight;
    flight.lookAheadMm = 0; // rays stand on the line
    const FlightCurve curve(path.lines, flight);
    if (!sized) {
        double radius = 0;
        const std::vector<RoutePoint> route = routeOf(path.lines, flight.route);
        for (const RoutePoint& point : route)
            radius += std::max(point.radiusMm, 0.5) / static_cast<double>(route.size());
        const double pixelMm = 2 * std::acos(-1.0) * radius / scene.imageSize.x;
        scene.imageSize.y =
            std::clamp(static_cast<int>(std::lround(curve.lengthMm() / pixelMm)), 1, Scene::kMaxImageExtent);
    }
    std::vector<UnfoldedRow> rows;
    for (int y = 0; y < scene.imageSize.y; ++y) {
        const Pose pose = curve.at(curve.lengthMm() * (y + 0.5) / scene.imageSize.y);
        rows.push_back({pose.at, pose.direction, pose.up});
    }
    return rows;
}

} // namespace

void renderWall(const RenderTask& task) {
    const RenderArguments& arguments = task.arguments;
    Scene scene = task.scene; // its height follows from the line unless it is given
    const Path path = pathOf(task);
    const std::vector<UnfoldedRow> rows =
        rowsOf(path, arguments.path, arguments.keys.says("image.size"), scene);
    const RenderResult result = renderUnfolded(scene, rows, task.store, task.ram, task.gpu, task.options);
    const Charge pictures =
        task.ram.charge(kPictureBytesPerPixel * result.image.pixels.size(), "the picture");
    task.common.progress->stage("writing the picture");
    nlohmann::json report = makeManifest(scene, task.store, result, task.ram, task.gpu);
    report["unfolded"] = {{"route", path.flight->route},
                          {"fromMm", path.flight->fromMm},
                          {"lengthMm", FlightCurve(path.lines, *path.flight).lengthMm()},
                          {"backwards", path.flight->backwards},
                          {"columns", "360 degrees, from up, clockwise along the line"}};
    writePicture(arguments.out, result.image, scene.background, manifestText(report));
    task.common.progress->end();
    if (arguments.json) {
        report["output"] = arguments.out;
        report["blank"] = isBlank(result.image);
        printReport(report);
    }
    finishStandardOutput();
    noteWritten(task, scene, result, ", unfolded");
}

} // namespace tessera

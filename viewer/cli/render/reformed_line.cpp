// viewer/cli/render/reformed_line.cpp: see reformed_line.h.
#include "viewer/cli/render/reformed_line.h"

#include "core/animation/reformed_line.h"
#include "core/base/error.h"
#include "core/base/names.h"
#include "core/base/output_file.h"
#include "core/scene/camera.h"
#include "core/scene/measurement.h"
#include "core/scene/reformed_sheet.h"
#include "render/picture/reformed_picture.h"
#include "render/plan/frame_plan.h" // kPictureBytesPerPixel
#include "viewer/annotations/figure_file.h"
#include "viewer/annotations/figure_page.h"
#include "viewer/annotations/figure_part.h"
#include "viewer/cli/manifest/manifest.h"
#include "viewer/cli/options/command.h" // lengthsOf
#include "viewer/cli/render/along_path.h"
#include "viewer/cli/render/asked_options.h"
#include "viewer/cli/render/picture_files.h"
#include "viewer/cli/render/picture_notes.h"
#include "viewer/cli/render/reformed_marks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {

void checkReformation(const RenderArguments& a) {
    const std::string form = a.pathPicture();
    if ((a.unfold && a.reforms()) || (a.straighten && a.curved))
        throw badFile(form, "one of --unfold, --straighten and --curved", "two");
    if (a.angle && !a.straighten && a.sections == 0)
        throw badFile("--angle", "--straighten or --sections with it", "none");
    if (a.angles > 0 && !a.straighten)
        throw badFile("--angles", "--straighten with it", "none");
    if (a.angle && a.angles > 0)
        throw badFile("--angles", "--angle or --angles, which are spread over half a turn", "both");
    if (!a.direction.empty() && !a.curved)
        throw badFile("--direction", "--curved with it", "none");
    if (a.widthMm > 0 && !a.reforms())
        throw badFile("--across", "--straighten, --curved or --sections with it", "none");
    if (!a.reforms())
        return;
    if (a.keys.says("image.size"))
        throw badFile("--size", "--across and --mm-per-pixel with " + form + ", whose size is the line's",
                      "--size");
    if (a.engine != "auto")
        throw badFile("--engine", "none with " + form + ", which casts no rays", a.engine);
    for (const auto& [said, option] : {std::pair{!a.view.empty() && !a.curved, "--view"},
                                       {!a.view.empty() && !a.direction.empty(), "--view"},
                                       {!a.fit.empty(), "--fit"},
                                       {!a.projection.empty(), "--projection"},
                                       {!a.mode.slice.empty(), "--slice"},
                                       {!a.first.empty(), "--first"},
                                       {!a.meshes.empty(), "--mesh"},
                                       {!a.surfaces.empty(), "--isosurface"},
                                       {a.explain, "--explain"}})
        if (said)
            throw badFile(option, std::string("no ") + option + " with " + form, option);
}

namespace {

/// The scene's camera; of a side one that looks at the line's middle from there. Curved pictures have their
/// axes of it.
Camera cameraOf(const Scene& scene, const FlightCurve& line) {
    constexpr double kDistanceMm = 1000;
    if (const auto* const camera = std::get_if<Camera>(&scene.camera))
        return *camera;
    const ViewAxes axes = axesOf(std::get<FittedView>(scene.camera));
    Camera camera;
    camera.projection = Projection::parallel;
    camera.focalPoint = line.at(0.5 * line.lengthMm()).at;
    camera.position = camera.focalPoint + kDistanceMm * axes.towards;
    camera.viewUp = axes.up;
    camera.parallelScale = 0.5 * line.lengthMm();
    return camera;
}

glm::dvec3 directionOf(const std::string& text) {
    const auto numbers = lengthsOf(text, 3);
    if (!numbers)
        throw badFile("--direction", "X,Y,Z", "\"" + text.substr(0, 40) + "\"");
    return {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
}

/// Six times the line's mean distance from the wall, at least 40 mm.
double widthOf(const Path& path) {
    constexpr double kLeastMm = 40, kRadii = 6;
    const std::vector<RoutePoint> route = routeOf(path.lines, path.flight->route);
    double radius = 0;
    for (const RoutePoint& point : route)
        radius += point.radiusMm / static_cast<double>(route.size());
    return std::max(kLeastMm, std::round(kRadii * radius));
}

/// Without a given size of pixels it is the smallest side of a voxel. Pixels that are larger get as many
/// samples along a side as they have voxels, so that no voxel is left out.
ReformedPixels pixelsOf(const RenderArguments& arguments, const Path& path, const VolumeInfo& info) {
    constexpr double kMostSamples = 8;
    const glm::dvec3 spacing = info.spacingMm();
    const double voxel = std::min({spacing.x, spacing.y, spacing.z});
    ReformedPixels pixels;
    pixels.widthMm = arguments.widthMm > 0 ? arguments.widthMm : widthOf(path);
    pixels.mmPerPixel = arguments.mmPerPixel > 0 ? arguments.mmPerPixel : voxel;
    pixels.samples =
        static_cast<int>(std::clamp(std::ceil(pixels.mmPerPixel / voxel - 1e-6), 1.0, kMostSamples));
    return pixels;
}

/// What is drawn, and what is said about it.
struct ReformedPictures {
    std::vector<Reformation> pictures;
    ReformedWords words;
};

std::string percent(std::size_t part, std::size_t all) {
    return formatNumber(
               100.0 * static_cast<double>(part) / static_cast<double>(std::max<std::size_t>(all, 1)), 2) +
           " %";
}

/// What is over the picture: it has one scale, and directions of the patient in each of its pictures.
Figure figureOf(const RenderTask& task, const Scene& scene, const RenderResult& result,
                const ReformedPictures& drawn) {
    FigurePart part = FigureMaker(scene, task.stores, task.ram, task.options.threads).part(scene, result);
    part.camera.projection = Projection::parallel;
    part.camera.parallelScale = parallelScaleOf(drawn.pictures.front().mmPerPixel, part.size);
    ReformedWords words = drawn.words;
    const bool asked = scene.annotations.directions != Directions::none;
    words.letters = asked && part.orientationKnown;
    if (!asked)
        words.angles.clear();
    if (words.letters)
        part.annotations.directions = Directions::none; // there are none of the whole
    part.inner = innerPictures(drawn.pictures, task.arguments.straighten, words);
    return figureOf(std::move(part), scene.annotations.dpi);
}

/// Pictures along the line.
int picturesAlong(const RenderArguments& arguments) {
    return arguments.curved ? 1 : arguments.straighten ? std::max(1, arguments.angles) : 0;
}

/// The pictures of the arguments, laid out.
/// @param about  what the manifest says of them
ReformedPictures picturesOf(const RenderTask& task, const FlightCurve& line, const Camera& camera,
                            const ReformedPixels& pixels, nlohmann::json& about) {
    const RenderArguments& arguments = task.arguments;
    const int count = picturesAlong(arguments);
    const double angle = arguments.angle.value_or(0);
    ReformedPictures made;
    nlohmann::json angles = nlohmann::json::array();
    about = {{"form", "sections"}};
    if (arguments.straighten) {
        for (int n = 0; n < count; ++n) {
            angles.push_back(angle + 180.0 * n / count);
            made.pictures.push_back(straightened(line, angles.back().get<double>(), pixels));
        }
        about = {{"form", "straightened"}, {"top", "beginning"}};
        if (arguments.angles > 0 || angle != 0)
            made.words.angles = angles.get<std::vector<double>>();
    } else if (arguments.curved) {
        const glm::dmat3 axes = patientFromCamera(camera);
        const bool named = !arguments.direction.empty();
        const glm::dvec3 direction = named ? directionOf(arguments.direction) : axes[0];
        Stretched picture = stretched(line, direction, axes[1], pixels);
        about = {{"form", "stretched"},
                 {"direction", {direction.x, direction.y, direction.z}},
                 {"directionBy", named ? "--direction" : "view"},
                 {"top", picture.endOnTop ? "end" : "beginning"}};
        made.pictures.push_back(std::move(picture.picture));
    }
    if (arguments.sections > 0) {
        made.words.sectionMm = sectionPlaces(line, arguments.sections);
        for (const double mm : made.words.sectionMm)
            made.pictures.push_back(crossSection(line, mm, angle, pixels));
        about["sectionsMm"] = made.words.sectionMm;
        if (!arguments.straighten)
            angles.push_back(angle);
    }
    if (!angles.empty()) {
        about["anglesDegrees"] = angles;
        about["viewer"] = "from up, clockwise along the line";
    }
    made.words.lineMm = line.lengthMm();
    layOutPictures(made.pictures);
    return made;
}

} // namespace

void renderReformedLine(const RenderTask& task) {
    const RenderArguments& arguments = task.arguments;
    const Path path = pathOf(task);
    if (!path.flight)
        throw badFile(arguments.path, "a path with lines", "one of keyframes");
    Flight flight = *path.flight;
    flight.lookAheadMm = 0; // rows stand on the line
    const FlightCurve line(path.lines, flight);
    const ReformedPixels pixels = pixelsOf(arguments, path, task.store.info());
    const Camera camera = cameraOf(task.scene, line);
    const Charge ofRows =
        task.ram.charge(reformedBytes(line, pixels) * static_cast<std::size_t>(picturesAlong(arguments)) +
                            sectionBytes(pixels) * static_cast<std::size_t>(arguments.sections),
                        "the rows of a reformation");
    nlohmann::json about;
    const ReformedPictures drawn = picturesOf(task, line, camera, pixels, about);

    RenderOptions options = task.options;
    options.progress = task.common.progress.get();
    ReformedShare share;
    RenderResult result = renderReformed(task.scene, drawn.pictures, task.store, task.ram, options, share);
    result.camera = camera;
    const Charge written = task.ram.charge(kPictureBytesPerPixel * result.image.pixels.size(), "the picture");
    task.common.progress->stage("writing the picture");
    Scene scene = task.scene;
    scene.imageSize = result.image.size;
    nlohmann::json report = makeManifest(scene, task.stores, result, task.ram, task.gpu);
    about.update({{"mmPerPixel", pixels.mmPerPixel},
                  {"samplesPerPixel", pixels.samples * pixels.samples},
                  {"widthMm", pixels.widthMm},
                  {"pictureSize", {drawn.pictures.front().size().x, drawn.pictures.front().size().y}},
                  {"slabMm", scene.slice.thicknessMm},
                  {"lineHash", digestOf(line)},
                  {"lineLengthMm", line.lengthMm()},
                  {"route", flight.route},
                  {"fromMm", flight.fromMm},
                  {"backwards", flight.backwards},
                  {"pixels", share.pixels},
                  {"outsidePixels", share.outside},
                  {"foldedPixels", share.folded}});
    if (scene.slice.thicknessMm > 0)
        about["slab"] = nameOf(scene.slice.reduction);
    report["reformation"] = std::move(about);
    tellPath(report, path);
    report["options"] = optionsJson(task);
    const bool blank = isBlank(result.image);
    const Figure figure = figureOf(task, scene, result, drawn);
    tellAnnotations(report, figure);
    if (scene.background)
        result.image = overBackground(result.image, *scene.background);
    writeFigure(arguments.out, std::move(result.image), figure, manifestText(report), {}, task.ram);
    task.common.progress->end();
    if (blank)
        printProblem(
            "the picture is blank: the line does not meet the drawn part of the volume, which lies in " +
            placeOf(task.store.info()));
    if (arguments.json) {
        report["output"] = arguments.out;
        report["blank"] = blank;
        printReport(report);
    }
    finishStandardOutput();
    if (const std::string words = leftOutText(report); !words.empty())
        task.common.note(words);
    if (share.folded > 0)
        task.common.note(percent(share.folded, share.pixels) +
                         " of the pixels are hatched: they lie beyond the line's centre of curvature, where "
                         "rows cross one another");
    noteWritten(task, scene, result,
                arguments.straighten ? ", straightened"
                : arguments.curved   ? ", stretched"
                                     : ", cross-sections");
}

} // namespace tessera

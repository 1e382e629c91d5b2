// viewer/cli/render/along_path.cpp: see along_path.h.
#include "viewer/cli/render/along_path.h"

#include "core/animation/film.h"
#include "core/animation/flight.h"
#include "core/animation/reformed_line.h" // digestOf
#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/scene/preset.h"
#include "render/picture/unfolded.h"
#include "render/plan/fusion.h"
#include "viewer/annotations/figure_file.h"
#include "viewer/annotations/figure_page.h"
#include "viewer/annotations/figure_part.h"
#include "viewer/cli/input/phase_input.h"
#include "viewer/cli/manifest/manifest.h"
#include "viewer/cli/render/asked_options.h"
#include "viewer/cli/render/phase_film.h"
#include "viewer/cli/render/picture_files.h"
#include "viewer/cli/render/picture_notes.h"
#include "viewer/cli/render/reformed_line.h"
#include "viewer/films/draw_film.h"
#include "viewer/paths/path_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {

namespace {

void checkTurnOptions(const RenderArguments& a) {
    if (!a.path.empty())
        throw badFile("--turn", "--turn or --path, which has the cameras", "both");
    for (const auto& [said, option] : {std::pair{a.speed > 0, "--speed"},
                                       {a.unfold, "--unfold"},
                                       {a.straighten, "--straighten"},
                                       {a.curved, "--curved"},
                                       {a.sections > 0, "--sections"},
                                       {a.mayLeak, "--may-leak"},
                                       {!a.first.empty(), "--first"},
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
    checkReformation(a);
    if (a.turn) {
        checkTurnOptions(a);
        return;
    }
    for (const auto& [said, option] :
         {std::pair{!a.frames.empty(), "--frames"}, {a.framesPerSecond > 0, "--fps"}})
        if (said && !film && !a.input.allPhases)
            throw badFile(option, "--path or --turn with it, or --phase all: it is for films", "none");
    for (const auto& [said, option] : {std::pair{a.speed > 0, "--speed"}, {a.seconds > 0, "--seconds"}})
        if (said && !film)
            throw badFile(option, "--path or --turn with it: it is for films", "none");
    const std::string onePicture = a.pathPicture();
    if (!onePicture.empty() && a.input.allPhases)
        throw badFile("--phase", "one phase with " + onePicture + ", which is one picture", "all");
    if (!onePicture.empty() && !film)
        throw badFile(onePicture, "--path with it, which has the line", "none");
    if (a.mayLeak && !a.unfold)
        throw badFile("--may-leak", "--unfold with it", "none");
    if (a.input.allPhases)
        for (const auto& [said, option] : {std::pair{!a.first.empty(), "--first"}, {a.explain, "--explain"}})
            if (said)
                throw badFile(option, std::string("no ") + option + " beside --phase all", option);
    if (!film)
        return;
    for (const auto& [said, option] : {std::pair{!a.frames.empty(), "--frames"},
                                       {a.framesPerSecond > 0, "--fps"},
                                       {a.speed > 0, "--speed"},
                                       {a.seconds > 0, "--seconds"},
                                       {!a.keys.textOf("--max-error").empty(), "--max-error"},
                                       {!a.verify.empty(), "--verify"}})
        if (said && !onePicture.empty())
            throw badFile(option,
                          std::string("no ") + option + " with " + onePicture + ", which is one picture",
                          option);
    if (a.reforms())
        return;
    for (const auto& [said, option] : {std::pair{!a.view.empty(), "--view"},
                                       {!a.fit.empty(), "--fit"},
                                       {!a.projection.empty(), "--projection"},
                                       {a.mmPerPixel > 0, "--mm-per-pixel"},
                                       {!a.first.empty(), "--first"},
                                       {a.explain, "--explain"}})
        if (said)
            throw badFile(option, std::string("no ") + option + " with --path, which has the cameras",
                          option);
    if (a.speed > 0 && a.seconds > 0)
        throw badFile("--speed", "--speed or --seconds, which chooses a speed", "both");
}

Path readPathOf(const RenderArguments& arguments) {
    return arguments.givenPath ? *arguments.givenPath : loadPathFile(arguments.path);
}

void tellPath(nlohmann::json& manifest, const Path& path) {
    constexpr std::size_t kMostPoints = 20000; // some hundred bytes each
    const Path alone = flightAlone(path);
    std::size_t points = 0;
    for (const CentreLine& line : alone.lines)
        points += line.points.size();
    if (points <= kMostPoints)
        manifest["path"] = nlohmann::json::parse(pathJson(alone));
}

Path pathOf(const RenderTask& task) {
    const RenderArguments& a = task.arguments;
    Path path = readPathOf(a);
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
    const Camera camera = turningCamera(scene, task.stores, task.ram, task.options.threads);
    return turntable(camera, *a.turn, frames, framesPerSecond);
}

namespace {

/// A still camera, a frame each phase.
Path phasesPath(const RenderTask& task) {
    const RenderArguments& a = task.arguments;
    return stillPath(std::get<Camera>(task.scene.camera), task.phases->stores.size(),
                     a.framesPerSecond > 0 ? a.framesPerSecond : Path().framesPerSecond);
}

/// Those of a still of this frame: its phase is chosen.
nlohmann::json frameOptions(const RenderTask& task, const nlohmann::json& frame) {
    nlohmann::json options = optionsJson(task);
    if (!frame.contains("phase"))
        return options;
    nlohmann::json& sources = options["sources"];
    if (!sources.is_array())
        sources = nlohmann::json::array({nlohmann::json::object()});
    sources.at(0)["phase"] = frame["phase"];
    return options;
}

} // namespace

void renderFilm(const RenderTask& given) {
    RenderTask task = given;
    FilmJob job;
    std::optional<ValueSummary> values; // of all phases
    if (task.phases) {
        SharedByPhases shared = sharedByPhases(task);
        task.scene = std::move(shared.scene);
        values = std::move(shared.values);
        for (std::size_t n = 0; n < shared.hashes.size(); ++n) {
            Annotations words = task.scene.annotations;
            namePhase(words, task.phases->labels[n]); // or is refused before a frame is drawn
            job.phases.push_back({task.phases->labels[n], shared.hashes[n], task.phases->stores[n]});
        }
        job.open = task.open;
    }
    const RenderArguments& arguments = task.arguments;
    const Scene& scene = task.scene;
    const auto presets = [&](const std::string& preset) {
        const Statistics statistics = loadStatistics(task.store, task.ram, task.options.threads);
        return presetFunction(preset, summarise(statistics, task.store.info(), scene.volumes.front().unit));
    };
    const bool turns = arguments.turn.has_value(), moves = !arguments.path.empty();
    Path path = turns ? turnOf(task) : moves ? pathOf(task) : phasesPath(task);
    if (values)
        path = withFunctions(std::move(path), *values);
    const Film film(std::move(path), scene, presets,
                    turns   ? "--turn"
                    : moves ? arguments.path
                            : "--phase all");
    job.film = &film;
    job.scene = scene;
    job.range = arguments.frames.empty() || turns ? FrameRange{0, film.frames() - 1}
                                                  : parseFrames(arguments.frames, film.frames());
    job.out = arguments.out;
    job.options = task.options;
    job.stores = task.stores;
    job.ram = &task.ram;
    job.gpu = &task.gpu;
    // Read before the frames' own memory is taken.
    const FigureMaker maker(scene, task.stores, task.ram, task.options.threads);
    bool told = false; // of what had no room
    // Frames have one size: that of the first, with the longest name of a phase.
    Strips strips;
    if (scene.annotations.margin != AnnotationMargin::none) {
        std::vector<std::string> labels = {""};
        for (const FilmJob::Phase& phase : job.phases)
            labels.push_back(phase.label);
        for (const std::string& label : labels) {
            Scene ofFirst = film.scene(0);
            ofFirst.annotations.namePhase(label);
            strips = larger(strips, stripsOf(maker.partToCome(ofFirst), ofFirst.annotations.dpi));
        }
    }
    Charge page; // of the frame at hand, with its strips
    job.annotate = [&](const Scene& ofFrame, const RenderResult& result, Image& picture,
                       nlohmann::json& manifest) {
        manifest["options"] = frameOptions(task, manifest["film"]);
        if (!scene.annotations.any())
            return;
        const Figure figure = figureOf(maker.part(ofFrame, result), ofFrame.annotations.dpi, strips);
        page = {};
        page = task.ram.charge(2 * pageBytes(figure), "the picture with its strips");
        tellAnnotations(manifest, figure);
        annotate(picture, figure);
        if (const std::string words = leftOutText(manifest); !words.empty() && !std::exchange(told, true))
            task.common.note("frame " + std::to_string(manifest["film"]["frame"].get<std::size_t>()) + ": " +
                             words);
    };
    const FilmReport report =
        drawFilm(job, task.common,
                 [](const std::filesystem::path& path, const Image& image, const std::string& manifest) {
                     writePicture(path, image, std::nullopt, manifest);
                 });
    if (report.blank > 0 && report.blank == report.drawn)
        task.common.problem("all frames are blank: the path's cameras see nothing that is shown");
    if (arguments.json) {
        nlohmann::json out = {{"output", arguments.out},
                              {"frames", report.frames},
                              {"first", job.range.first},
                              {"drawn", report.drawn},
                              {"there", report.there},
                              {"byOthers", report.byOthers},
                              {"withBricksOfTheOneBefore", report.goneOn},
                              {"blank", report.blank},
                              {"framesPerSecond", film.path().framesPerSecond},
                              {"seconds",
                               {{"all", report.seconds},
                                {"preparing", report.preparing},
                                {"loading", report.loading},
                                {"drawing", report.drawing},
                                {"ofFrames", report.frameSeconds}}}};
        if (!job.phases.empty())
            out["phases"] = job.phases.size();
        printReport(out);
    }
    finishStandardOutput();
    task.common.note(
        "wrote " + arguments.out + ": " + std::to_string(report.frames) + " frames of " +
        std::to_string(scene.imageSize.x) + " x " + std::to_string(scene.imageSize.y) + ", " +
        formatNumber(static_cast<double>(report.frames) / film.path().framesPerSecond, 3) + " s at " +
        formatNumber(film.path().framesPerSecond, 4) + " frames/s" +
        (report.there > 0 ? "; " + std::to_string(report.there) + " were there" : std::string()));
}

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
        if (std::none_of(route.begin(), route.end(), [](const RoutePoint& p) { return p.radiusMm > 0; }))
            throw badFile(where, "a line with radii, which give the picture its height, or --size", "none");
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
    const std::vector<UnfoldedRow> rows = rowsOf(path, arguments.path, arguments.isSized(), scene);
    const RenderResult result = renderUnfolded(scene, rows, task.store, task.ram, task.gpu, task.options);
    const Charge pictures =
        task.ram.charge(kPictureBytesPerPixel * result.image.pixels.size(), "the picture");
    task.common.progress->stage("writing the picture");
    nlohmann::json report = makeManifest(scene, task.stores, result, task.ram, task.gpu);
    const FlightCurve line(path.lines, *path.flight);
    report["unfolded"] = {
        {"route", path.flight->route},         {"fromMm", path.flight->fromMm},
        {"lengthMm", line.lengthMm()},         {"lineHash", digestOf(line)},
        {"backwards", path.flight->backwards}, {"columns", "360 degrees, from up, clockwise along the line"}};
    tellPath(report, path);
    report["options"] = optionsJson(task);
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

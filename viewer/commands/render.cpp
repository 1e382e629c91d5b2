// viewer/commands/render.cpp: `tessera render X -o OUT`: one converged picture of a scene, a store or source
// files.
#include "bricking/store/store_reader.h"
#include "core/error.h"
#include "core/film.h"
#include "core/interrupt.h"
#include "core/look.h"
#include "core/nearest_name.h"
#include "core/output_file.h"
#include "core/preset.h"
#include "core/scene.h"
#include "render/plan/scene_plan.h" // renderFloorBytes
#include "render/renderer.h"
#include "render/unfolded.h"
#include "viewer/commands/commands.h"
#include "viewer/films/draw_film.h"
#include "viewer/films/movie_file.h"
#include "viewer/input/selection_options.h"
#include "viewer/input/thin_volume.h"
#include "viewer/input/volume_input.h"
#include "viewer/manifest/manifest.h"
#include "viewer/options/mode_options.h"
#include "viewer/options/option_values.h"
#include "viewer/presets/preset_library.h"
#if TESSERA_WITH_IMAGE_FILES
#include "core/image_file.h"
#endif

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <glm/vector_relational.hpp>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <unistd.h>

namespace tessera {
namespace {

namespace fs = std::filesystem;

struct RenderArguments {
    std::string in, out, engine = "auto", ram, gpuMemory, size, preset, view, fit, projection, background,
                         fetch;
    std::string device = "auto";
    double step = 0;                  // 0: as the scene says
    double maxError = -1;             // negative: as the scene says
    std::string samples, pixelFilter; // "": as the scene says
    int seed = -1;                    // negative: as the scene says
    std::string unit, edgeFunction, sampling, integrator, gradient, first;
    std::string light;
    std::vector<std::string> surfaces;
    std::string verify;
    std::string path, frames;                           // of films
    double framesPerSecond = 0, speed = 0, seconds = 0; // 0: as the path says
    bool unfold = false;
    bool noShading = false, noSkipping = false, noCheck = false, explain = false, json = false;
    ModeOptions mode;
    InputOptions input;
};

const std::vector<std::string> kEngineNames = {"auto", "gpu", "native", "mirror",
                                               "reference"};                   // in the order of EngineKind
const std::vector<std::string> kProjectionNames = {"perspective", "parallel"}; // in the order of Projection

std::size_t chosen(const std::string& text, const std::vector<std::string>& names,
                   const std::string& option) {
    const auto found = std::find(names.begin(), names.end(), text);
    if (found == names.end())
        throw badFile(option, "one of " + joinNames(names),
                      "\"" + text + "\"; nearest: \"" + nearestName(text, names) + "\"");
    return static_cast<std::size_t>(found - names.begin());
}

/// "300", "300:#eeddcc" or "300:#eeddcc:0.5".
Isosurface parseSurface(const std::string& text) {
    const auto refuse = [&] {
        return badFile("--isosurface", "VALUE, VALUE:#rrggbb or VALUE:#rrggbb:OPACITY (0 to 1)",
                       "\"" + text.substr(0, 40) + "\"");
    };
    std::vector<std::string> parts;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, ':');)
        parts.push_back(part);
    const auto number = [&](const std::string& word) {
        char* end = nullptr;
        const double value = std::strtod(word.c_str(), &end);
        if (word.empty() || *end != '\0' || !std::isfinite(value))
            throw refuse();
        return value;
    };
    if (parts.empty() || parts.size() > 3 || text.back() == ':')
        throw refuse();
    Isosurface surface{number(parts[0])};
    if (parts.size() > 1) {
        const std::optional<glm::vec3> colour = parseBackground(parts[1], "--isosurface");
        if (!colour)
            throw refuse();
        surface.colour = glm::dvec3(*colour);
    }
    if (parts.size() > 2)
        surface.opacity = number(parts[2]);
    if (!(surface.opacity >= 0 && surface.opacity <= 1))
        throw refuse();
    return surface;
}

/// `--no-check` is `--verify none`; `--max-error` needs the truth.
Verify parseVerify(const RenderArguments& arguments) {
    const std::vector<std::string>& names = verifyNames();
    if (arguments.noCheck && !arguments.verify.empty() && arguments.verify != names.front())
        throw badFile("--no-check", "--verify or --no-check, which is --verify none", "both");
    if (arguments.noCheck)
        return Verify::none;
    if (arguments.verify.empty()) // of films nobody reads what every frame errs by
        return arguments.path.empty() ? Verify::quick : Verify::none;
    const auto at = std::find(names.begin(), names.end(), arguments.verify);
    if (at == names.end())
        throw badFile("--verify", joinNames(names), "\"" + arguments.verify.substr(0, 40) + "\"");
    return static_cast<Verify>(at - names.begin());
}

/// Samples a pixel: a whole number, or auto.
int parseSamples(const std::string& text) {
    if (text == "auto")
        return PixelSampling::kAutomatic;
    char* end = nullptr;
    const long samples = std::strtol(text.c_str(), &end, 10);
    if (text.find_first_not_of("0123456789") != std::string::npos || *end != '\0' || samples < 1 ||
        samples > PixelSampling::kMost)
        throw badFile("--samples", "auto or a whole number from 1 to " + std::to_string(PixelSampling::kMost),
                      "\"" + text.substr(0, 40) + "\"");
    return static_cast<int>(samples);
}

/// A preset of a file, or one that was kept: its function, and all that it says of light, mode and cuts.
void applyFoundPreset(const std::string& text, Scene& scene, const CommonOptions& common) {
    try {
        const FoundPreset found = findPreset(text);
        applyPreset(found.preset, scene);
        for (const std::string& what : found.leftOut)
            common.note(text + ": left out: " + what);
    } catch (const InputError& e) {
        throw InputError(std::string("--preset: ") + e.what());
    }
}

/// Options win over the scene.
void applyOptions(const RenderArguments& arguments, Scene& scene, const CommonOptions& common) {
    if (!arguments.unit.empty())
        scene.volumes.front().unit = parseUnit(arguments.unit);
    if (!arguments.preset.empty()) {
        if (isOwnOrFile(arguments.preset))
            applyFoundPreset(arguments.preset, scene, common);
        else
            scene.volumes.front().transferFunction = arguments.preset;
    }
    if (!arguments.light.empty()) { // wins over the preset's
        chosen(arguments.light, lookNames(), "--light");
        applyLook(arguments.light, scene);
    }
    if (!arguments.size.empty())
        scene.imageSize = parseImageSize(arguments.size, "--size", Scene::kMaxImageExtent);
    if (!arguments.background.empty())
        scene.background = parseBackground(arguments.background, "--background");
    if (!arguments.view.empty()) {
        FittedView view{parseView(arguments.view, "--view")};
        if (const auto* before = std::get_if<FittedView>(&scene.camera))
            view = {view.view, before->projection, before->fit};
        view.named = true;
        scene.camera = view;
    }
    applyModeOptions(arguments.mode, scene);
    if (const auto* fitted = std::get_if<FittedView>(&scene.camera);
        scene.mode == Mode::slice && fitted && !fitted->named)
        for (const auto& [text, option] :
             {std::pair{arguments.fit, "--fit"}, {arguments.projection, "--projection"}})
            if (!text.empty())
                throw badFile(option,
                              "--view beside it: a slice is looked at along its normal, in parallel, and "
                              "fills the picture",
                              "none");
    if (!arguments.fit.empty()) {
        auto* fitted = std::get_if<FittedView>(&scene.camera);
        if (!fitted)
            throw badFile("--fit", "a camera by side (--view), which is fitted", "one that is spelled out");
        fitted->fit = parseFit(arguments.fit, "--fit");
    }
    if (!arguments.projection.empty()) {
        const auto projection =
            static_cast<Projection>(chosen(arguments.projection, kProjectionNames, "--projection"));
        std::visit([projection](auto& camera) { camera.projection = projection; }, scene.camera);
    }
    if (!arguments.fetch.empty())
        scene.quality.fetch = parseFetch(arguments.fetch, "--fetch");
    if (arguments.step != 0) {
        scene.quality.stepVoxels = arguments.step;
        scene.quality.automaticStep = false;
        if (arguments.maxError > 0)
            throw badFile("--step", "--step or --max-error, which chooses a step", "both");
    }
    if (!arguments.edgeFunction.empty())
        scene.quality.edgeFunction = parseEdgeFunction(arguments.edgeFunction, "--edge-function");
    if (!arguments.integrator.empty())
        scene.quality.integrator = parseIntegrator(arguments.integrator, "--integrator");
    if (!arguments.sampling.empty())
        scene.quality.sampling = parseSampling(arguments.sampling, "--sampling");
    if (!arguments.gradient.empty())
        scene.shading.gradient = parseGradient(arguments.gradient, "--gradient");
    if (arguments.maxError >= 0)
        scene.quality.maxError = arguments.maxError;
    PixelSampling& pixels = scene.quality.pixels;
    if (!arguments.samples.empty())
        pixels.samples = parseSamples(arguments.samples);
    else if (!pixels.named && arguments.engine != "mirror" && arguments.engine != "reference")
        pixels.samples = PixelSampling::kAutomatic;
    pixels.named = true; // so that the manifest's scene is the picture's
    if (!arguments.pixelFilter.empty())
        scene.quality.pixels.filter = parsePixelFilter(arguments.pixelFilter, "--pixel-filter");
    if (arguments.seed >= 0)
        scene.quality.pixels.seed = static_cast<std::uint32_t>(arguments.seed);
    for (const std::string& text : arguments.surfaces)
        scene.surfaces.push_back(parseSurface(text));
    if (scene.surfaces.size() > Scene::kMaxSurfaces)
        throw badFile("--isosurface", "at most " + std::to_string(Scene::kMaxSurfaces) + " isosurfaces",
                      std::to_string(scene.surfaces.size()));
    if (arguments.noShading)
        scene.shading.on = false;
    if (arguments.noSkipping)
        scene.quality.skipping = false;
}

/// Whether the transfer function shows any value of the volume.
bool showsAnything(const TransferChoice& choice, const RenderResult& result) {
    const auto* function = std::get_if<TransferFunction>(&choice);
    if (!function) {
        const std::string& preset = std::get<std::string>(choice);
        if (preset == "auto")
            return result.highest > result.lowest;
        const TransferFunction named = presetFunction(preset, {result.lowest, result.highest, true, 1, {}});
        return showsAnything(named, result);
    }
    if (function->extinction(result.lowest) > 0 || function->extinction(result.highest) > 0)
        return true;
    return std::any_of(function->kinks().begin(), function->kinks().end(), [&](double v) {
        return v >= result.lowest && v <= result.highest && function->extinction(v) > 0;
    });
}

/// A file that goes when the command ends, however it ends.
class PassingFile {
  public:
    explicit PassingFile(const fs::path& path) : path_(path), unfinished_(path) {}
    ~PassingFile() {
        std::error_code ignored;
        fs::remove(path_, ignored);
    }
    PassingFile(const PassingFile&) = delete;
    PassingFile& operator=(const PassingFile&) = delete;

  private:
    fs::path path_;
    TemporaryPath unfinished_;
};

#if !TESSERA_WITH_IMAGE_FILES
std::string readManifest(const fs::path&) {
    return {};
}
#endif

/// Of a coarse first picture that nobody asked for: tells one that a killed process left from somebody's.
constexpr const char* kFirstManifest = R"({"tesseraFirstPicture":1,"notice":"not for diagnosis"})";
bool isFirstPicture(const fs::path& path) {
    try {
        return readManifest(path) == kFirstManifest;
    } catch (const Error&) {
        return false;
    }
}

/// Pictures that take so long, and of which a coarse one takes so much less, that a first one is worth its
/// time.
bool isLarge(const VolumeInfo& info, const Scene& scene) {
    constexpr int kVoxels = 256, kPixels = 256 * 256; // at fewer there is little to wait for
    return glm::any(glm::greaterThan(info.extentVoxels, glm::ivec3(kVoxels))) &&
           scene.imageSize.x * scene.imageSize.y >= kPixels;
}

/// From the system's own account of when this process began: loading the program counts too.
double secondsSinceProcessStart() {
    std::ifstream stat("/proc/self/stat");
    std::string text((std::istreambuf_iterator<char>(stat)), {});
    std::istringstream fields(text.substr(std::min(text.rfind(')') + 1, text.size())));
    std::string field;
    for (int i = 3; i <= 22 && fields >> field; ++i)
        ; // field 22: start, in clock ticks since the system's
    timespec now{};
    clock_gettime(CLOCK_BOOTTIME, &now);
    const double start = std::strtod(field.c_str(), nullptr) / static_cast<double>(sysconf(_SC_CLK_TCK));
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec) - start;
}

/// "level 2" or "levels 0 to 4", and the passes where there were several.
std::string levelText(const RenderResult& result) {
    int coarsest = result.level;
    for (int level = 0; level < kLevelCount; ++level)
        if (result.bricksOfLevel[static_cast<std::size_t>(level)] > 0)
            coarsest = level;
    std::string text = coarsest <= result.level
                           ? "level " + std::to_string(result.level)
                           : "levels " + std::to_string(result.level) + " to " + std::to_string(coarsest);
    if (result.passes > 1)
        text += " in " + std::to_string(result.passes) + " passes";
    return text;
}

/// A blank picture is no error, but never a silent one.
void warnBlank(const RenderArguments& arguments, const Scene& scene, const VolumeInfo& info,
               const RenderResult& result) {
    const std::string unit = info.unit.empty() ? "" : " " + info.unit;
    std::string why = "the camera sees nothing of the volume", fix = " --view anterior";
    if (!(result.highest > result.lowest)) {
        why = "all values of the volume are the same", fix = "";
    } else if (reductionOf(scene) == Reduction::composite && scene.mode != Mode::isosurface &&
               !showsAnything(scene.volumes.front().transferFunction, result)) {
        why = "the transfer function shows none of the volume's values", fix = " --preset auto";
    }
    printProblem("the picture is blank: " + why + "; they go from " + formatNumber(result.lowest) + " to " +
                 formatNumber(result.highest) + unit + "; try: " +
                 (fix.empty() ? "tessera info " + arguments.in
                              : "tessera render " + arguments.in + " -o " + arguments.out + fix));
}

Scene sceneOf(const RenderArguments& arguments) {
    if (isSceneFile(arguments.in))
        return loadScene(arguments.in);
    Scene scene;
    scene.quality.automaticStep = true;
    scene.volumes.push_back(
        {fs::path(arguments.in), std::string()}); // the function follows from the values' unit
    return scene;
}

#if TESSERA_WITH_IMAGE_FILES
void checkOutput(const fs::path& out) {
    checkImagePath(out);
    checkOutputFile(out);
}
#else
void checkOutput(const fs::path&) {
    throw InputError("render: this program was built without picture files");
}
void checkImagePath(const fs::path&) {
    throw InputError("render: this program was built without picture files");
}
void writeImage(const fs::path&, const Image&, const std::string&) {}
#endif

/// A film goes into a folder, or into a file of its own.
void checkFilmOutput(const fs::path& out) {
    if (isMovieFile(out)) {
        checkMovieFile(out);
        return;
    }
    const std::string extension = out.extension().string();
    if (extension == ".png" || extension == ".exr" || extension == ".tif" || extension == ".tiff")
        throw badFile(out.string(), "a folder for frames (-o frames/) or a film (.mp4, .mov, .mkv)",
                      "a picture");
    checkImagePath("frame.png");
}

/// A budget too small even for reading the store: the message names what the scene needs, not just the
/// reader.
void requireFloor(const fs::path& path, const Scene& scene, EngineKind engine, const Ledger& ram) {
    constexpr std::size_t kReaderBytes = std::size_t{4} << 20; // enough for the reader of any store
    if (ram.limitBytes() >= kReaderBytes)
        return;
    Ledger trial(ram.name(), ram.option(), kReaderBytes);
    const VolumeInfo info = StoreReader(path, trial).info();
    const std::size_t floor =
        renderFloorBytes(info, scene.imageSize, pictureBytesPerPixel(engine, scene.quality.pixels), 0);
    if (ram.limitBytes() < floor)
        throw InputError(ram.option() + ": this scene needs at least " + formatBytes(floor) +
                         ", but the budget is " + formatBytes(ram.limitBytes()));
}

/// Where nobody asked for samples and RAM is too short for the sums that they take, pixels get one ray.
void fitSamples(const VolumeInfo& info, EngineKind engine, const Ledger& ram, Scene& scene,
                const CommonOptions& common) {
    const auto floor = [&] {
        return renderFloorBytes(info, scene.imageSize, pictureBytesPerPixel(engine, scene.quality.pixels), 0,
                                scene.quality.integrator);
    };
    PixelSampling& pixels = scene.quality.pixels;
    if (ram.limitBytes() >= floor())
        return;
    const PixelSampling asked = pixels;
    pixels.samples = 1;
    if (ram.limitBytes() < floor())
        pixels = asked; // it is not for them
    else
        common.note("--ram has no room for more than one ray a pixel: " + formatBytes(ram.limitBytes()));
}

/// What is said of films alone, or not of them.
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

/// The path as the options have it.
Path pathOf(const RenderArguments& a, const VolumeInfo& info, const std::string& contentHash,
            const CommonOptions& common) {
    Path path = loadPath(a.path);
    const bool cameras = std::any_of(path.keyframes.begin(), path.keyframes.end(),
                                     [](const Keyframe& key) { return key.camera.has_value(); });
    if (!path.flight && !cameras && !path.lines.empty())
        path.flight = Flight{}; // a line alone is flown
    if (path.volume && path.volume->contentHash != contentHash)
        common.note(a.path + ": its lines were made in another volume (" +
                    formatExtent(path.volume->extentVoxels) + " voxels; this one has " +
                    formatExtent(info.extentVoxels) + ")");
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

/// A film; the scene is complete but for its camera.
void runFilm(const RenderArguments& arguments, const CommonOptions& common, const Scene& scene,
             const StoreReader& store, Ledger& ram, Ledger& gpu, const RenderOptions& options) {
    const auto presets = [&](const std::string& preset) {
        const Statistics statistics = loadStatistics(store, ram, options.threads);
        return presetFunction(preset, summarise(statistics, store.info(), scene.volumes.front().unit));
    };
    const Film film(pathOf(arguments, store.info(), store.contentHash(), common), scene, presets,
                    arguments.path);
    FilmJob job;
    job.film = &film;
    job.scene = scene;
    job.range = arguments.frames.empty() ? FrameRange{0, film.frames() - 1}
                                         : parseFrames(arguments.frames, film.frames());
    job.out = arguments.out;
    job.options = options;
    job.store = &store;
    job.ram = &ram;
    job.gpu = &gpu;
    const FilmReport report = drawFilm(job, common, writeImage);
    if (report.blank > 0 && report.blank == report.drawn)
        printProblem("all frames are blank: the path's cameras see nothing that is shown");
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
        std::printf("%s\n", out.dump(2, ' ', true, nlohmann::json::error_handler_t::replace).c_str());
    }
    finishStandardOutput();
    common.note("wrote " + arguments.out + ": " + std::to_string(report.frames) + " frames of " +
                std::to_string(scene.imageSize.x) + " x " + std::to_string(scene.imageSize.y) + ", " +
                formatNumber(static_cast<double>(report.frames) / film.path().framesPerSecond, 3) + " s at " +
                formatNumber(film.path().framesPerSecond, 4) + " frames/s" +
                (report.there > 0 ? "; " + std::to_string(report.there) + " were there" : std::string()));
}

/// Rows along the flight's line. Where nobody says how large the picture is, its width is as given, and a
/// pixel is as high as it is wide on a wall at the line's mean distance from it.
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

void runUnfolded(const RenderArguments& arguments, const CommonOptions& common, Scene scene,
                 const StoreReader& store, Ledger& ram, Ledger& gpu, const RenderOptions& options) {
    const Path path = pathOf(arguments, store.info(), store.contentHash(), common);
    const std::vector<UnfoldedRow> rows = rowsOf(path, arguments.path, !arguments.size.empty(), scene);
    const RenderResult result = renderUnfolded(scene, rows, store, ram, gpu, options);
    const Charge pictures = ram.charge(kPictureBytesPerPixel * result.image.pixels.size(), "the picture");
    common.progress->stage("writing the picture");
    nlohmann::json report = makeManifest(scene, store, result, ram, gpu);
    report["unfolded"] = {{"route", path.flight->route},
                          {"fromMm", path.flight->fromMm},
                          {"lengthMm", FlightCurve(path.lines, *path.flight).lengthMm()},
                          {"backwards", path.flight->backwards},
                          {"columns", "360 degrees, from up, clockwise along the line"}};
    const Image picture = scene.background ? overBackground(result.image, *scene.background) : result.image;
    writeImage(arguments.out, picture, report.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
    common.progress->end();
    if (arguments.json) {
        report["output"] = arguments.out;
        report["blank"] = isBlank(result.image);
        std::printf("%s\n", report.dump(2, ' ', true, nlohmann::json::error_handler_t::replace).c_str());
    }
    finishStandardOutput();
    common.note(
        "wrote " + arguments.out + ": " + std::to_string(scene.imageSize.x) + " x " +
        std::to_string(scene.imageSize.y) + ", unfolded, " + levelText(result) + ", " + result.device + ", " +
        formatNumber(result.secondsPreparing + result.secondsLoading + result.secondsDrawing, 3) + " s");
}

void runRender(const RenderArguments& arguments, const CommonOptions& common) {
    // Everything that can be refused is refused before the long work.
    checkFilmOptions(arguments);
    if (!arguments.path.empty())
        loadPath(arguments.path);
    if (arguments.path.empty() || arguments.unfold)
        checkOutput(arguments.out);
    else
        checkFilmOutput(arguments.out);
    const std::string engineName = arguments.engine == "march" ? "gpu" : arguments.engine; // its name before
    const auto engine = static_cast<EngineKind>(chosen(engineName, kEngineNames, "--engine"));
    const bool drawsFirst = engine != EngineKind::mirror && engine != EngineKind::reference;
    Scene scene = sceneOf(arguments);
    const bool samplesNamed = scene.quality.pixels.named || !arguments.samples.empty();
    applyOptions(arguments, scene, common);
    Ledger ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    Ledger gpu("GPU memory", "--gpu-memory", budgetBytes(arguments.gpuMemory, "--gpu-memory", common));

    SceneVolume& volume = scene.volumes.front();
    volume.path = storeFor(volume.path, arguments.input, ram, common);
    requireFloor(volume.path, scene, engine, ram);
    const StoreReader store(volume.path, ram);
    if (!samplesNamed)
        fitSamples(store.info(), engine, ram, scene, common);
    if (arguments.path.empty())
        requireFacingView(scene, store.info(), arguments.in);
    if (const auto* preset = std::get_if<std::string>(&volume.transferFunction); preset && preset->empty())
        volume.transferFunction =
            std::string(store.info().unit == "HU" || volume.unit == "HU" ? "bone" : "auto");

    RenderOptions options;
    options.engine = engine;
    options.device.text = arguments.device;
    options.searching = true;
    options.verify = parseVerify(arguments);
    options.checking = options.verify != Verify::none;
    if (arguments.unfold) {
        runUnfolded(arguments, common, scene, store, ram, gpu, options);
        return;
    }
    if (!arguments.path.empty()) {
        runFilm(arguments, common, scene, store, ram, gpu, options);
        return;
    }
    double firstSeconds = 0;
    if (!arguments.first.empty() && !drawsFirst)
        throw badFile("--first", "--engine auto, gpu or native", arguments.engine);
    std::optional<PassingFile> passing;
    fs::path first = arguments.first;
    if (first.empty() && drawsFirst && common.progress->watched() && isLarge(store.info(), scene)) {
        first = fs::path(arguments.out)
                    .replace_extension(".first" + fs::path(arguments.out).extension().string());
        std::error_code ignored;
        if (fs::exists(first, ignored) && !isFirstPicture(first))
            first.clear(); // somebody's
        else
            passing.emplace(first);
    }
    options.progress = common.progress.get();
    if (!first.empty())
        options.onFirstPicture = [&](const Image& image, double secondsLeft) {
            const Charge charge =
                ram.charge(kPictureBytesPerPixel * image.pixels.size() / 2, "the first picture");
            writeImage(first, scene.background ? overBackground(image, *scene.background) : image,
                       passing ? kFirstManifest : "{}");
            firstSeconds = secondsSinceProcessStart();
            common.note("wrote " + first.string() + ", coarse, after " + formatNumber(firstSeconds, 3) +
                        " s; the picture takes about " + formatNumber(std::ceil(secondsLeft), 2) + " s more");
        };
    const RenderResult result = renderScene(scene, store, ram, gpu, options);
    if (arguments.fetch == "hardware" && result.engine == EngineKind::native)
        common.note("--fetch hardware: the native engine fetches exactly");
    if (result.takenAsHu)
        common.note(
            "the values have no unit, but look like HU (air near -1000): taken as HU; --unit HU says so");
    const Charge pictures = ram.charge(kPictureBytesPerPixel * result.image.pixels.size(), "the picture");

    common.progress->stage("writing the picture");
    nlohmann::json report = makeManifest(scene, store, result, ram, gpu);
    const Image picture = scene.background ? overBackground(result.image, *scene.background) : result.image;
    // ASCII only: PNG's text is Latin-1, and what a device calls itself is not ours to trust.
    writeImage(arguments.out, picture, report.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));

    common.progress->end();
    const bool blank = isBlank(result.image);
    if (blank)
        warnBlank(arguments, scene, store.info(), result);
    const std::vector<std::string> lines =
        arguments.explain ? explain(result, scene) : std::vector<std::string>();
    if (arguments.json) {
        report["output"] = arguments.out;
        report["blank"] = blank;
        report["seconds"] = {{"preparing", result.secondsPreparing},
                             {"loading", result.secondsLoading},
                             {"drawing", result.secondsDrawing},
                             {"checking", result.secondsChecking}};
        if (firstSeconds > 0)
            report["seconds"]["firstPictureSinceStart"] = firstSeconds;
        if (arguments.explain)
            report["explain"] = lines;
        std::printf("%s\n", report.dump(2, ' ', true, nlohmann::json::error_handler_t::replace).c_str());
    } else {
        for (const std::string& line : lines)
            std::printf("%s\n", line.c_str());
    }
    finishStandardOutput();
    if (const double asked = scene.quality.maxError.value_or(0); asked > 0 && !result.shortfall.empty())
        common.note("the picture is not known to be within --max-error " + formatNumber(asked, 2) + ": " +
                    result.shortfall);
    else if (asked > 0 && !result.measured && result.errors && result.errors->luvP99() > asked)
        common.note("the picture's error is estimated at " + formatNumber(result.errors->luvP99(), 2) +
                    " (L*u*v*, 99th percentile), more than " + formatNumber(asked, 2) +
                    ": no step tried is fine enough");
    common.note("wrote " + arguments.out + ": " + std::to_string(scene.imageSize.x) + " x " +
                std::to_string(scene.imageSize.y) + ", " + levelText(result) + ", " + result.device + ", " +
                formatNumber(result.secondsPreparing + result.secondsLoading + result.secondsDrawing, 3) +
                " s");
    common.detail("most charged: RAM " + formatBytes(ram.peakBytes()) + " of " +
                  formatBytes(ram.limitBytes()) + ", GPU memory " + formatBytes(gpu.peakBytes()) + " of " +
                  formatBytes(gpu.limitBytes()));
}

} // namespace

void addRenderCommand(CLI::App& program, const CommonOptions& common, Action& action) {
    auto* command = program.add_subcommand("render", "Draw a picture of a scene, a store or source files");
    auto a = std::make_shared<RenderArguments>();
    command->add_option("X", a->in, "scene (.json), store (.zarr), DICOM folder, .nii, ...")->required();
    command
        ->add_option(
            "-o,--output", a->out,
            "picture to write: .png, .exr, .tif; replaced if it exists. With --path a folder for frames, or "
            "a film: .mp4, .mov, .mkv")
        ->required();
    command->add_option(
        "--path", a->path,
        "draw a film: cameras, and what else changes, from a path (.json); frames that are there stay, "
        "and several processes may draw into one folder");
    command->add_flag(
        "--unfold", a->unfold,
        "with --path: one picture of the wall around the line, slit open: angles from left to right, the "
        "line from top to bottom");
    command->add_option("--frames", a->frames, "of the film, from 0: A or A-B (default: all)");
    command->add_option("--fps", a->framesPerSecond, "frames per second (default: as the path says)")
        ->check(numberWithin(0.1, 1000, "a number from 0.1 to 1000"));
    command->add_option("--speed", a->speed, "of the flight, mm/s (default: as the path says)")
        ->check(numberWithin(0.01, 1e5, "mm/s from 0.01 to 100000"));
    command->add_option("--seconds", a->seconds, "that the flight takes, whatever its speed")
        ->check(numberWithin(0.01, 1e6, "seconds from 0.01 to 1000000"));
    command->add_option("--size", a->size, "pixels, WIDTHxHEIGHT (default: 512x512)");
    command->add_option("--light", a->light,
                        joinNames(lookNames()) +
                            ": lights, shadows and occlusion (default: plain, or the scene's)");
    command->add_option("--preset", a->preset,
                        joinNames(presetNames()) +
                            ", one that was kept, or a file as `tessera preset` reads it (default: bone "
                            "for HU, auto for other values)");
    command->add_option("--view", a->view,
                        joinNames(viewNames()) + "; also front, back, top, bottom (default: anterior)");
    addModeOptions(*command, a->mode);
    command->add_option("--fit", a->fit,
                        "what fills the picture: all that is shown, or the volume's box: " +
                            joinNames(fitNames()) + " (default: shown)");
    command->add_option("--projection", a->projection, joinNames(kProjectionNames));
    command->add_option("--background", a->background, "black, white, #rrggbb or transparent");
    command
        ->add_option("--engine", a->engine,
                     joinNames(kEngineNames) + "; auto: gpu where there is one, else native")
        ->capture_default_str();
    command
        ->add_option(
            "--step", a->step,
            "distance of samples at the finest level, in voxels (default: the longest whose estimated "
            "error is within 1/255)")
        ->check(numberWithin(1.0 / 64, 16, "voxels from 1/64 to 16"));
    command
        ->add_option(
            "--max-error", a->maxError,
            "error to stay below (L*u*v*, 99th percentile; measured, or with --verify none predicted): takes "
            "levels, step, integrator and samples that cost the least, in as many passes as the budget "
            "needs; "
            "0: the finest levels that a pixel can show (default: the best that fits at once)")
        ->check(numberWithin(0, std::numeric_limits<double>::max(), "a number from 0 on"));
    command->add_option(
        "--first", a->first,
        "write a first, coarse picture here as soon as there is one, before the picture itself");
    command->add_option("--edge-function", a->edgeFunction,
                        "blend between bricks: " + joinNames(edgeFunctionNames()) + " (default: split)");
    command->add_option("--sampling", a->sampling,
                        "steps in coarse bricks: " + joinNames(samplingNames()) + " (default: limited)");
    command->add_option(
        "--isosurface", a->surfaces,
        "a surface of one value, e.g. 300, 300:#eeddcc or -400:#ffccaa:0.3 (colour, opacity); "
        "several are drawn with several such options");
    command->add_option("--integrator", a->integrator,
                        "what a segment of a ray adds: " + joinNames(integratorNames()) +
                            " (default: auto, as the transfer function asks)");
    command->add_option("--samples", a->samples,
                        "rays through each pixel, 1 to " + std::to_string(PixelSampling::kMost) +
                            ", whose mean it shows, or auto: more where they are needed; 1: one through its "
                            "middle (default: auto; 1 with --engine mirror and reference)");
    command->add_option("--pixel-filter", a->pixelFilter,
                        "what a pixel with several samples is the mean of: its own area, or a Gaussian that "
                        "reaches beyond: " +
                            joinNames(pixelFilterNames()) + " (default: box)");
    command->add_option("--seed", a->seed, "another choice of where in a pixel samples lie (default: 0)")
        ->check(wholeNumberFrom(0));
    command->add_option("--fetch", a->fetch, joinNames(fetchNames()));
    command->add_option("--gradient", a->gradient,
                        "how surfaces are found for shading: " + joinNames(gradientNames()) +
                            " (default: central)");
    command->add_flag("--no-shading", a->noShading, "colours as the transfer function has them");
    command->add_flag("--no-skipping", a->noSkipping,
                      "sample empty space too; the picture is the same, but where --samples auto asks empty "
                      "space where to look");
    command->add_option("--verify", a->verify,
                        "draw some pixels again as they should be and say how wrong the picture is: " +
                            joinNames(verifyNames()) + " (default: quick)");
    command->add_flag("--no-check", a->noCheck, "the same as --verify none");
    command->add_option("--gpu-memory", a->gpuMemory, "budget, e.g. 256MiB (default: 1 GiB at most)");
    command->add_option("--ram", a->ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    command->add_option("--gl-device", a->device, "auto, software, or a device's number")
        ->capture_default_str();
    command->add_flag("--explain", a->explain, "list what is in the picture and what was left out");
    command->add_flag("--json", a->json, "print the picture's manifest and timings");
    addSelectionOptions(*command, a->input);
    command->add_option("--unit", a->unit, "HU: the values are in HU, though the file cannot say so (NIfTI)");
    command->footer("Example:\n  tessera render abdomen.zarr -o liver.png --preset soft-tissue --view left");
    command->callback([a, &common, &action] { action = [a, &common] { runRender(*a, common); }; });
}

} // namespace tessera

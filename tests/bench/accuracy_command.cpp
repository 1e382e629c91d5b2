// tests/bench/accuracy_command.cpp: `tessera accuracy SCENE -o FOLDER`: how wrong the picture is, what
// less error costs, and what breaks; and with --all the scenes of docs/measurements/accuracy.md.
#include "bricking/store/store_reader.h"
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "core/base/names.h"
#include "core/base/program_folders.h"
#include "core/scene/preset.h"
#include "render/backends/engine_maker.h"
#include "render/backends/gpu/gl/context.h"
#include "tests/bench/accuracy/accuracy_report.h"
#include "tests/bench/accuracy/area_sweep.h"
#include "tests/bench/accuracy/light_sweep.h"
#include "tests/bench/accuracy/scene_section.h"
#include "tests/bench/accuracy/scenes.h"
#include "tests/bench/lod/workbench.h" // scansFolder
#include "tests/bench/report/page.h"
#include "tests/bench/study_commands.h"
#include "viewer/cli/input/named_scene.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/manifest/build_commit.h"

#include <algorithm>
#include <cstdlib>
#include <memory>

namespace tessera {
namespace {

namespace fs = std::filesystem;
using namespace accuracy;

struct AccuracyArguments {
    std::string in, out, scans, keptScenes, ram, gpuMemory, size, preset, engine = "auto", device = "auto";
    std::vector<std::string> only, integrators, peers;
    double seconds = 0;
    bool all = false, quick = false, noShading = false, pixelsOnly = false, lightOnly = false;
    InputOptions input;
};

constexpr const char* kHeading = "# Error against run time: what was measured\n\n"
                                 "How wrong is a picture, what does less error cost, and what breaks when "
                                 "the data or the transfer function turn "
                                 "nasty. This page is generated, with its figures and the CSV files beside "
                                 "it, by `tessera accuracy`; each section "
                                 "says how and where it was made.\n";

/// If `tessera bench lod` has left its figure of promised errors, the page begins with it.
std::string headingIn(const fs::path& folder) {
    const fs::path figure = fs::path("level-of-detail") / "calibration.svg";
    std::error_code none;
    if (!fs::exists(folder / figure, none))
        return kHeading;
    return std::string(kHeading) +
           "\nWhat a picture says of its own error, before it is drawn (crosses) and measured afterwards "
           "(points), "
           "against its true error: CIE L\\*u\\*v\\* at the 99th percentile, a point a picture. "
           "[level-of-detail.md](level-of-detail.md#promised-and-true-errors) has the cases behind it; "
           "`tessera bench lod --only calibration` measures them.\n\n![Promised against true error](" +
           figure.generic_string() + ")\n";
}

/// A name that a file may have.
std::string plainName(const std::string& text) {
    std::string name;
    for (const char c : text)
        name += std::isalnum(static_cast<unsigned char>(c)) || c == '-' ? c : '-';
    return name.empty() ? "scene" : name;
}

/// The scene that a user names: a scene file, or a store or source files as `tessera render` shows them.
NamedScene namedScene(const AccuracyArguments& arguments, MemoryBudget& ram, const CommonOptions& common) {
    NamedScene named;
    named.name = plainName(fs::path(arguments.in).stem().string());
    named.scene = sceneOf(arguments.in);
    SceneVolume& volume = named.scene.volumes.front();
    volume.path = storeFor(volume, arguments.input, ram, common);
    volume.source = {};
    if (!arguments.preset.empty())
        volume.transferFunction = arguments.preset;
    nameFunction(volume, StoreReader(volume.path, ram).info());
    if (!arguments.size.empty())
        named.scene.imageSize = parseImageSize(arguments.size, "--size", Scene::kMaxImageExtent);
    if (arguments.noShading)
        named.scene.shading.on = false;
    named.about = "A scene that was given.";
    return named;
}

std::vector<std::string> omissionsOf(const std::vector<NamedScene>& scenes,
                                     const std::vector<PeerPoint>& peers,
                                     const std::vector<std::string>& leftOut) {
    std::vector<std::string> omissions = {
        "FLIP: no package of Debian 12 brings it; the column is empty.",
        "A bound of the whole picture: only what ending rays early may leave out is claimed and tested "
        "(`bound`). Errors "
        "of levels are predicted, not bounded; that of filtered fetches is bounded for values, not for "
        "pixels; that of "
        "the step has no bound that holds for every function.",
        "Pictures in several passes: their time is mostly loading. Levels that do not fit at once are "
        "refused instead.",
        "A cold cache: all bricks are on the device before a frame is timed.",
        "Jitter and other random methods: there are none."};
    std::string without, elsewhere;
    for (const NamedScene& scene : scenes)
        if (std::none_of(peers.begin(), peers.end(),
                         [&](const PeerPoint& p) { return p.scene == scene.name; }))
            without += (without.empty() ? "`" : ", `") + scene.name + "`";
    for (const PeerPoint& p : peers)
        if (std::none_of(scenes.begin(), scenes.end(),
                         [&](const NamedScene& scene) { return p.scene == scene.name; }) &&
            elsewhere.find("`" + p.scene + "`") == std::string::npos)
            elsewhere += (elsewhere.empty() ? "`" : ", `") + p.scene + "`";
    if (peers.empty())
        omissions.push_back(
            "Other renderers: none were measured beside these runs (`--peers FILE.csv` adds them).");
    else if (!without.empty())
        omissions.push_back("Other renderers of " + without + ": none were measured.");
    if (!elsewhere.empty())
        omissions.push_back("Other renderers of " + elsewhere + ": measured, but of no scene of this page.");
    omissions.insert(omissions.end(), leftOut.begin(), leftOut.end());
    return omissions;
}

void makeFolder(const std::string& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
        throw badFile(folder, "a folder to write in", error.message());
}

/// The command as it may be repeated: all that decides what is on the page, with FOLDER, FILE and SCENE in
/// the place of paths, because paths carry names.
std::string commandText(const AccuracyArguments& a) {
    std::string text = std::string("tessera accuracy ") + (a.all ? "--all" : "SCENE") + " -o FOLDER";
    const auto add = [&text](const char* option, const std::string& value) {
        if (!value.empty())
            text += std::string(" ") + option + " " + value;
    };
    const auto addAll = [&text](const char* option, const std::vector<std::string>& values) {
        if (!values.empty())
            text += std::string(" ") + option;
        for (const std::string& value : values)
            text += " " + value;
    };
    const auto addFlag = [&text](const char* option, bool on) {
        if (on)
            text += std::string(" ") + option;
    };
    addAll("--only", a.only);
    add("--scans", a.scans.empty() ? "" : "FOLDER");
    addFlag("--quick", a.quick);
    add("--seconds", a.seconds > 0 ? formatNumber(a.seconds) : "");
    addAll("--integrators", a.integrators);
    addAll("--peers", std::vector<std::string>(a.peers.size(), "FILE"));
    add("--size", a.size);
    add("--preset", a.preset);
    addFlag("--no-shading", a.noShading);
    add("--gpu-memory", a.gpuMemory);
    add("--ram", a.ram);
    add("--engine", a.engine == "auto" ? "" : a.engine);
    add("--gl-device", a.device == "auto" ? "" : a.device);
    add("--series", a.input.series > 0 ? std::to_string(a.input.series) : "");
    addFlag("--pixels-only", a.pixelsOnly);
    addFlag("--light-only", a.lightOnly);
    addFlag("--largest", a.input.largest);
    addFlag("--resample-z", a.input.resampleZ);
    return text;
}

void runAccuracy(const AccuracyArguments& arguments, const CommonOptions& common) {
    if (arguments.in.empty() != arguments.all)
        throw InputError(arguments.all
                             ? "accuracy: expected a scene or --all, found both"
                             : "accuracy: expected a scene, a store, source files or --all, found none");
    if (!arguments.only.empty() && !arguments.all)
        throw InputError("accuracy: --only: expected --all, of whose scenes it names some, found none");
    if (!arguments.preset.empty())
        indexOfName(arguments.preset, presetNames(), "--preset"); // throws for one that is not there
    SweepOptions options;
    options.engine = bench::studyEngine(arguments.engine);
    options.device = arguments.device;
    options.ramBytes = budgetBytes(arguments.ram, "--ram", common);
    options.gpuBytes = budgetBytes(arguments.gpuMemory, "--gpu-memory", common);
    options.effort.quick = arguments.quick;
    options.effort.seconds = arguments.seconds;
    for (const std::string& name : arguments.integrators) {
        options.integrators.push_back(parseName<Integrator>(name, "--integrators"));
        if (options.integrators.back() == Integrator::automatic)
            throw badFile("--integrators", "an integrator that is one", "\"" + name + "\"");
    }
    if (!arguments.keptScenes.empty() && !arguments.all)
        throw InputError("accuracy: --keep-scenes: expected --all, whose scenes it keeps, found none");
    if (arguments.out.empty() && arguments.keptScenes.empty())
        throw InputError("accuracy: expected -o FOLDER for the page, found none");
    checkGlDevice({arguments.device});
    // An engine that is not there is refused before the truth is drawn, which takes minutes.
    static_cast<void>(EngineMaker(options.engine, {arguments.device}).about());
    for (const std::string& folder : {arguments.out, arguments.keptScenes})
        if (!folder.empty())
            makeFolder(folder);

    const ScratchFolder scratch;
    std::vector<NamedScene> scenes;
    std::vector<std::string> leftOut;
    {
        MemoryBudget ram("RAM", "--ram", options.ramBytes);
        if (arguments.all) {
            const bool keep = !arguments.keptScenes.empty();
            const fs::path folder = keep ? fs::path(arguments.keptScenes) : scratch.path();
            StandardScenes made = standardScenes(folder, bench::scansFolder(arguments.scans), arguments.only,
                                                 arguments.quick, options.ramBytes, common, keep);
            if (keep)
                keepScenes(made.scenes, folder, options.ramBytes);
            scenes = std::move(made.scenes);
            leftOut = std::move(made.leftOut);
        } else {
            scenes.push_back(namedScene(arguments, ram, common));
        }
    }
    if (arguments.out.empty()) { // only the scenes were asked for
        for (const std::string& sentence : leftOut)
            common.note(sentence);
        common.note("wrote " + std::to_string(scenes.size()) + " scenes to " + arguments.keptScenes);
        return;
    }
    std::vector<PeerPoint> peers;
    for (const std::string& file : arguments.peers) {
        const auto more = loadPeers(file, scenes.size() == 1 ? scenes.front().name : "");
        peers.insert(peers.end(), more.begin(), more.end());
    }

    std::vector<AreaSweep> areas;
    for (const NamedScene& scene : scenes) {
        if (arguments.lightOnly)
            break;
        common.progress->stage(scene.name + ": samples of a pixel");
        areas.push_back(runAreaSweep(scene, options));
    }
    std::vector<LightSweep> lights;
    for (const NamedScene& scene : scenes) {
        if (arguments.pixelsOnly)
            break;
        common.progress->stage(scene.name + ": light of voxels");
        if (auto light = runLightSweep(scene, options))
            lights.push_back(std::move(*light));
    }
    const std::string commit = buildCommit();
    const auto write = [&](const std::vector<bench::Report>& reports, const std::string& machine,
                           const std::vector<std::string>& order) {
        const bench::PagePlace place{arguments.out, "accuracy", headingIn(arguments.out), order};
        const bench::MadeBy madeBy{
            commandText(arguments), machine + "; load " + bench::formatCell(bench::loadAverage()),
            std::string(TESSERA_VERSION) + (commit.empty() ? "" : " (" + commit + ")")};
        std::size_t withoutFigure = 0;
        for (const bench::Report& report : reports)
            withoutFigure += bench::writeReport(report, madeBy, place);
        if (withoutFigure > 0)
            common.note(bench::withoutFigures(withoutFigure));
        common.note("wrote " + (fs::path(arguments.out) / "accuracy.md").string());
    };
    if (arguments.lightOnly && lights.empty())
        throw InputError("accuracy: --light-only: expected a scene with occlusion or shadows, found none");
    if (arguments.pixelsOnly || arguments.lightOnly) { // the page keeps its other sections
        std::vector<std::string> order = {"reference", "pixels", "light"};
        for (const std::string& name : standardSceneNames())
            order.push_back("scene-" + name);
        order.insert(order.end(), {"stiff", "defaults", "runs"});
        return write({arguments.lightOnly ? lightSection(lights) : areaSection(areas)},
                     bench::describeMachine("CPU"), order);
    }

    std::vector<Sweep> sweeps;
    for (const NamedScene& scene : scenes) {
        common.progress->stage(scene.name + ": drawing it as it is");
        sweeps.push_back(runSweep(scene, options, common));
    }
    if (sweeps.empty())
        throw InputError("accuracy: expected a scene that can be measured, found none");

    const MeasuredOn on{"Tessera " TESSERA_VERSION, commit, bench::describeMachine(sweeps.front().device)};
    std::vector<bench::Report> reports = {referenceSection(sweeps, on, options.effort), areaSection(areas)};
    if (!lights.empty())
        reports.push_back(lightSection(lights));
    for (const Sweep& sweep : sweeps)
        reports.push_back(sceneSection(sweep, peers));
    reports.push_back(stiffSection());
    reports.push_back(defaultsSection(sweeps));
    reports.push_back(runsSection(sweeps, on, omissionsOf(scenes, peers, leftOut)));
    std::vector<std::string> order;
    for (const bench::Report& report : reports)
        order.push_back(report.name);
    write(reports, on.machine, order);
}

} // namespace

void addAccuracyCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command(
        "accuracy", "Measure the error of a scene's picture, and the time that a smaller error takes");
    auto a = std::make_shared<AccuracyArguments>();
    command.option("SCENE", a->in, "scene (.json), store (.zarr), DICOM folder, .nii, ...");
    command.option("-o,--output", a->out,
                   "folder for the page accuracy.md and the folder accuracy beside it");
    command.flag("--all", a->all, "the scenes of docs/measurements/accuracy.md instead of one");
    command.option("--only", a->only, "with --all: only these scenes: " + joinNames(standardSceneNames()));
    command.option("--scans", a->scans,
                   "with --all: folder with the public scans (default: $TESSERA_TEST_DATA)");
    command.flag("--pixels-only", a->pixelsOnly, "measure only cost and gain of samples per pixel");
    command.flag("--light-only", a->lightOnly, "measure only error and cost of light per voxel")
        .excludes("--pixels-only");
    command.flag("--quick", a->quick, "small pictures, fewer settings and repeats: about a minute");
    command
        .option("--seconds", a->seconds,
                "time for the first pictures of a scene; later settings are left out, and listed, and times "
                "have fewer repeats (default: 40 with --quick, else no limit)")
        .check(numberWithin(std::numeric_limits<double>::min(), std::numeric_limits<double>::max(),
                            "seconds, more than 0"));
    command.option("--integrators", a->integrators,
                   "integrators to compare, of " + joinNames(integratorNames()) + " (default: all but auto)");
    command.option("--peers", a->peers,
                   "CSV files of other renderers on the same scenes: scene, renderer, time_min_ms, rmse");
    command.option("--keep-scenes", a->keptScenes,
                   "with --all: folder for the scenes as files, with their volumes, for other renderers; "
                   "without -o nothing else is done");
    command.option("--size", a->size,
                   "size in pixels, WIDTHxHEIGHT, at most 512 are drawn (default: the scene's)");
    command.option("--preset", a->preset, "preset in place of the scene's transfer function");
    command.flag("--no-shading", a->noShading, "draw the transfer function's colours, unlit");
    command.option("--gpu-memory", a->gpuMemory, "budget, e.g. 256MiB (default: 1 GiB at most)");
    command.option("--ram", a->ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    command.option("--engine", a->engine, "engine to measure: " + joinNames(bench::studyEngineNames()))
        .showsDefault();
    command.option("--gl-device", a->device, "auto, software or a number").showsDefault();
    command.option("--series", a->input.series, "source files: number of the DICOM series")
        .check(wholeNumberFrom(1));
    command.flag("--largest", a->input.largest,
                 "source files: the largest CT of a folder with several volumes");
    command.flag("--resample-z", a->input.resampleZ, "source files: interpolate uneven slices");
    command.footer("Example:\n  tessera accuracy scene.json -o results --quick");
    command.whenChosen([a, &common, &action] { action = [a, &common] { runAccuracy(*a, common); }; });
}

} // namespace tessera

// viewer/cli/view.cpp: `tessera view [X]`: a window on a scene, a store or source files.
#include "core/base/address.h"
#include "core/base/budget.h"
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "core/base/names.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/input/named_scene.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/options/scene_options.h"
#include "viewer/presets/preset_library.h"
#include "viewer/session/view_session.h"
#include "viewer/window/run_window.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tessera {
namespace {

struct ViewArguments {
    std::string in, beside, engine = "auto", ram, gpuMemory, size, script;
    double frameMs = 60;
    bool noStills = false, noPanels = false;
    InputOptions input;
    std::vector<std::string> sets;
    KeyOptions labels; // of the scene of `in`
};

void checkLabels(const ViewArguments& arguments) {
    const std::string file = arguments.labels.textOf("--labels");
    std::error_code ignored;
    if (!file.empty() && arguments.in.empty())
        throw badFile("--labels", "a volume or a scene that they lie beside", "none");
    if (!file.empty() && !std::filesystem::exists(file, ignored))
        throw badFile("--labels " + file, "a file or folder of labels", "nothing there");
}

/// Refuses keys that the scene cannot have, before a window opens. A scene that cannot be read is left to the
/// window, which says so.
void checkSets(const ViewArguments& arguments) {
    Scene scene = sceneOf("volume"); // any, where none is named
    try {
        if (!arguments.in.empty())
            scene = sceneOf(arguments.in);
    } catch (const InputError&) {
        return;
    }
    applySets(arguments.sets, scene);
    arguments.labels.apply(scene);
    checkLabels(arguments);
}

void runView(const ViewArguments& arguments, const CommonOptions& common) {
    if (!arguments.in.empty() && looksLikeStore(arguments.in))
        requireNoChoice(arguments.in, arguments.input, common);
    ViewSessionOptions session;
    checkSets(arguments);
    session.engine = engineNamed(arguments.engine, "--engine", true);
    session.ramBytes = budgetBytes(arguments.ram, "--ram", common);
    session.gpuBytes = budgetBytes(arguments.gpuMemory, "--gpu-memory", common);
    if (!arguments.beside.empty()) {
        std::error_code ignored;
        if (!isAddress(arguments.beside) && !std::filesystem::exists(arguments.beside, ignored))
            throw badFile("--beside " + arguments.beside, "a volume", "nothing there");
        session.savedPanels = 2;
        session.ramBytes /= 2;
        session.gpuBytes /= 2;
    }
    session.frameMs = arguments.frameMs;
    session.stills = !arguments.noStills;
    session.input = arguments.input;
    session.sets = arguments.sets;
    session.own = arguments.in;
    session.anyFrame = arguments.labels.takesAnyFrame();
    session.setOwn = [&arguments](Scene& scene) { arguments.labels.apply(scene); };
    session.common = common;
    WindowOptions window;
    window.path = arguments.in;
    window.beside = arguments.beside;
    window.panels = !arguments.noPanels;
    if (!arguments.size.empty())
        window.size = parseImageSize(arguments.size, "--size", Scene::kMaxImageExtent);
    if (!arguments.script.empty())
        window.script = arguments.script;
    window.presets.names = ownPresetNames;
    window.presets.find = [](const std::string& text, std::vector<std::string>& leftOut) {
        FoundPreset found = findPreset(text);
        leftOut = std::move(found.leftOut);
        return found.preset;
    };
    window.presets.keep = keepPreset;
    window.presets.write = writePreset;
    window.makeViewing = [&](std::function<void()> news) {
        session.news = std::move(news);
        return makeViewSession(session);
    };
    runWindow(window);
}

} // namespace

void addViewCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command("view", "Open a window on a scene, a store or source files");
    auto a = std::make_shared<ViewArguments>();
    command.option(
        "X", a->in,
        "scene (.json), store (.zarr), DICOM folder, .nii, ... (default: none, drop one on the window)");
    command
        .option(
            "--beside", a->beside,
            "another scan at its right, with the same camera and look: two dates of a patient; each has half "
            "of both budgets")
        .needs("X");
    command.option("--size", a->size,
                   "size of the window, WIDTHxHEIGHT (default: the last one, at first 1280x720)");
    command
        .option("--engine", a->engine,
                joinNames(engineNames(true)) + "; auto: gpu if there is one, else native")
        .offers(engineNames(true))
        .showsDefault();
    command.option(
        "--gpu-memory", a->gpuMemory,
        "budget, e.g. 256MiB (default: 1 GiB at most); half for interactive pictures, half for stills");
    command.option("--ram", a->ram, "budget, e.g. 512MiB (default: 1 GiB at most); halved in the same way");
    command.option("--frame-ms", a->frameMs, "time of a picture during motion, milliseconds")
        .check(numberWithin(5, 10000, "milliseconds from 5 to 10000"))
        .showsDefault();
    command.flag("--no-stills", a->noStills, "draw no stills: one ray per pixel at rest");
    command.flag("--no-panels", a->noPanels, "start without panels");
    command.option("--script", a->script, "file of input for the window (user guide, \"The window\")");
    addSelectionOptions(command, a->input);
    addSpacingOption(command, a->input);
    addSetOption(command, a->sets, "every scene that is opened");
    a->labels.add(command, {"volumes[].labels"});
    command.footer("Example:\n  tessera view ct-abdomen/");
    command.whenChosen([a, &common, &action] { action = [a, &common] { runView(*a, common); }; });
}

} // namespace tessera

// viewer/cli/render.cpp: `tessera render X -o OUT`: one converged picture of a scene, a store or source
// files, a film or an unfolded wall. Its options; what is done is in viewer/cli/render/.
#include "core/base/names.h"
#include "core/scene/preset.h"
#include "core/scene/scene.h"
#include "core/scene/scene_presets.h"
#include "render/engine_traits.h"
#include "render/verify/verify_plan.h" // verifyNames
#include "viewer/cli/commands.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/render/layers.h"
#include "viewer/cli/render/run_render.h"
#include "viewer/cli/render/scene_from_arguments.h"

#include <memory>
#include <string>
#include <vector>

namespace tessera {
namespace {

std::string singleRayEngines() {
    std::vector<std::string> names;
    for (const EngineTraits& traits : engineTraits())
        if (traits.singleRays)
            names.push_back(traits.name);
    return joinNames(names);
}

} // namespace

void addRenderOptions(Command& command, const std::shared_ptr<RenderArguments>& a) {
    command.option("X", a->in, "scene (.json), store (.zarr), DICOM folder, .nii, ...").required();
    command
        .option("-o,--output", a->out,
                "picture to write: .png, .exr, .tif, .pdf, .svg; replaced if it exists. With --path or "
                "--turn a folder "
                "for frames, or "
                "a film: .mp4, .mov, .mkv")
        .required();
    command.option(
        "--path", a->path,
        "draw a film, with cameras and other changes from a path (.json), or along points: a curve of 3D "
        "Slicer (.mrk.json) or a table (.csv: x,y,z); existing frames stay, and several processes "
        "may share a folder");
    command.flag("--unfold", a->unfold,
                 "with --path: one picture of the wall around the line, cut open: angles from left to right, "
                 "the line from top to bottom");
    command.flag("--may-leak", a->mayLeak, "with --unfold: allow a lumen that leaks");
    command.flag("--straighten", a->straighten,
                 "with --path: one picture of the values around the line, straightened: its length from top "
                 "to bottom, mm across it from left to right");
    command
        .option("--angle", a->angle,
                "with --straighten: the viewer's direction, degrees about the line, clockwise from its upper "
                "side; with --sections: that of their upper edge (default: 0)")
        .check(numberWithin(-3600, 3600, "degrees from -3600 to 3600"));
    command
        .option("--angles", a->angles,
                "with --straighten: so many pictures side by side, evenly over half a turn")
        .check(numberWithin(2, 180, "a number from 2 to 180"))
        .check(wholeNumberFrom(2));
    command.flag("--curved", a->curved,
                 "with --path: one picture of the surface that the line sweeps along a direction, laid flat");
    command
        .option(
            "--sections", a->sections,
            "with --path: so many cross-sections, at right angles to the line and evenly along it; beside "
            "--straighten or --curved, or alone")
        .check(numberWithin(1, 200, "a number from 1 to 200"))
        .check(wholeNumberFrom(1));
    command.option("--direction", a->direction,
                   "with --curved: X,Y,Z of the direction, the picture's right (default: that of --view)");
    command
        .option("--across", a->widthMm,
                "with --straighten, --curved and --sections: mm across the line (default: by its radius)")
        .inUnit("mm")
        .check(numberWithin(0.01, 1e5, "mm from 0.01 to 100000"));
    command
        .option("--turn", a->turn,
                "draw a film of a turntable over this many degrees, 360 for a whole turn, from --view on")
        .check(numberWithin(-3600, 3600, "degrees from -3600 to 3600, not 0"))
        .check([](const std::string& text) {
            return std::stod(text) == 0 ? "expected degrees from -3600 to 3600, not 0, found 0"
                                        : std::string();
        });
    command.option(
        "--frames", a->frames,
        "frames of the film, from 0: A or A-B (default: all); with --turn their number (default: 120)");
    command.option("--fps", a->framesPerSecond, "frames per second (default: the path's)")
        .check(numberWithin(0.1, 1000, "a number from 0.1 to 1000"));
    command.option("--speed", a->speed, "speed of the flight, mm/s (default: the path's)")
        .inUnit("mm/s")
        .check(numberWithin(0.01, 1e5, "mm/s from 0.01 to 100000"));
    command.option("--seconds", a->seconds, "duration of the flight, in place of a speed")
        .inUnit("s")
        .check(numberWithin(0.01, 1e6, "seconds from 0.01 to 1000000"));
    command
        .option(
            "--tiles", a->tiles,
            "draw the picture in tiles of so many pixels along a side, so that memory is that of a tile; any "
            "number of processes with the same command draw it together")
        .check(numberWithin(64, 16384, "pixels from 64 to 16384"))
        .check(wholeNumberFrom(64));
    command.flag(
        "--ranks", a->ranks,
        "started by mpirun: draw the picture by all of its processes, each of which holds a part of the "
        "volume");
    // Options of keys are named here only for their place in the help.
    a->keys.word("{single-ray engines}", singleRayEngines());
    a->keys.add(command, {"image.size"});
    command
        .option("--light", a->light,
                joinNames(lookNames()) + ": lights, shadows and occlusion (default: plain, or the scene's)")
        .offers(lookNames());
    command
        .option("--preset", a->preset,
                joinNames(presetNames()) + ", a kept one, or a file that `tessera preset` reads (default: "
                                           "bone-1 for HU, auto for other values)")
        .offers(presetNames());
    command
        .option("--add", a->add,
                "another volume in the same picture, such as a PET on a CT, at its own place in patient "
                "space; may be repeated")
        .oneValueEach();
    command
        .option("--add-preset", a->addPresets,
                "preset of the volume of --add, in the same order; may be repeated (default: as --preset)")
        .oneValueEach();
    a->keys.add(command, {"fusion"});
    command
        .option("--label-preset", a->labelPresets,
                "LABELS=PRESET: a preset of their own for labels, named as for --show; may be repeated")
        .oneValueEach();
    command
        .option("--view", a->view,
                joinNames(viewNames()) +
                    "; also front, back, top, bottom; or TURN,RISE, degrees: about the patient's axis (0: "
                    "anterior, 90: left), and up (default: anterior)")
        .offers(viewNames());
    a->keys.add(command, {"mode", "window", "valueColour"});
    addModeOptions(command, a->mode);
    command
        .option("--fit", a->fit,
                "what the camera is fitted to, such as all that is shown, or the volume's box: " +
                    joinNames(fitNames()) + " (default: shown)")
        .offers(fitNames());
    command.option("--projection", a->projection, joinNames(namesOf<Projection>().all()))
        .offers(namesOf<Projection>().all());
    command
        .option("--mm-per-pixel", a->mmPerPixel,
                "edge of a pixel of a parallel picture, for one scale of several pictures (default: fitted)")
        .check(numberWithin(kLeastMmPerPixel, kMostMmPerPixel, "mm from 0.00001 to 10000"));
    a->keys.add(command, {"image.background"});
    command
        .option(
            "--panel", a->panels,
            "a figure of several pictures: sides between commas, TURN,RISE, a scene (.json), a volume, or "
            "KEY=VALUE with more behind semicolons; may be repeated")
        .oneValueEach();
    command.option("--columns", a->columns, "panels in a row (default: up to three, or about square)")
        .check(wholeNumberFrom(1))
        .needs("--panel");
    command.option("--gap", a->gap, "pixels between panels")
        .showsDefault()
        .check(wholeNumberFrom(0))
        .needs("--panel");
    command.flag("--fit-each", a->fitEach, "fit every panel for itself, in place of one scale for all panels")
        .needs("--panel");
    command.flag("--panel-letters", a->panelLetters, "A, B, C in the upper left corners of the panels")
        .needs("--panel");
    a->keys.add(command, {"annotations"});
    command
        .option("--engine", a->engine, joinNames(engineNames()) + "; auto: gpu if there is one, else native")
        .showsDefault()
        .offers(engineNames());
    a->keys.add(command, {"quality.stepVoxels", "quality.maxError"});
    command.option("--first", a->first, "file for a first, coarse picture, written as soon as it is ready");
    a->keys.add(command, {"quality.edgeFunction", "quality.sampling"});
    command.option(
        "--isosurface", a->surfaces,
        "a surface of one value, e.g. 300, 300:ivory or -400:#ffccaa:0.3 (colour, opacity); may be repeated");
    command.option(
        "--mesh", a->meshes,
        "a mesh to draw with the volume, .ply, .stl, .obj, .gltf or .glb, in patient space; may be "
        "repeated");
    command.option("--mesh-colour", a->meshColours,
                   "its colour, e.g. gold or #ddbb44 (default: light grey); of several meshes one each, the "
                   "last for the rest");
    command.option("--mesh-opacity", a->meshOpacities, "its opacity, 0 to 1 (default: 1), likewise");
    command.option("--mesh-space", a->meshSpace,
                   "axes of meshes' coordinates: " + joinNames(namesOf<MeshSpace>().all()) +
                       "; ras as 3D Slicer's own (default: lps, as DICOM)");
    command.option("--mesh-contours", a->meshContours,
                   "contours of DICOM structure sets: " + joinNames(namesOf<ContourStyle>().all()) +
                       "; surface joins those of a structure to a closed one (default: lines)");
    a->keys.add(command, {"quality.integrator", "quality.samples", "quality.pixelFilter", "quality.seed",
                          "quality.fetch", "shading.gradient", "shading", "quality"});
    command
        .option("--layers", a->layers,
                joinNames(layerNames()) +
                    ", or all: further layers of an .exr picture, for compositing; separated by commas")
        .oneValueEach();
    command.option("--keep-state", a->keepState,
                   "file for the samples of paths of light: a later run with more --samples or less --noise "
                   "goes on from it");
    command
        .option("--verify", a->verify,
                "draw some pixels again at full accuracy and report the picture's error: " +
                    joinNames(verifyNames()) + " (default: quick)")
        .offers(verifyNames());
    command.flag("--no-check", a->noCheck, "the same as --verify none");
    command.flag("--allow-damaged", a->allowDamaged,
                 "draw damaged chunks from coarser levels, and say so, in place of refusing the store");
    command.option("--gpu-memory", a->gpuMemory, "budget, e.g. 256MiB (default: 1 GiB at most)");
    command.option("--ram", a->ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    command.option("--gl-device", a->device, "auto, software, or a device's number").showsDefault();
    command.flag("--explain", a->explain, "list what the picture contains and what was left out");
    command.flag("--json", a->json, "print the picture's manifest and timings");
    addSelectionOptions(command, a->input, PhaseWords::all);
    addSpacingOption(command, a->input);
    a->keys.set(command);
    a->keys.addOthers(command);
}

void addRenderCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command("render", "Draw a picture of a scene, a store or source files");
    auto a = std::make_shared<RenderArguments>();
    addRenderOptions(command, a);
    command.footer("Example:\n  tessera render abdomen.zarr -o liver.png --preset soft-tissue --view left");
    command.whenChosen([a, &common, &action] { action = [a, &common] { runRender(*a, common); }; });
}

} // namespace tessera

// viewer/cli/redraw.cpp: `tessera redraw FIGURE`: draws a picture again from its own manifest.
#include "viewer/cli/redraw/run_redraw.h"

#include "viewer/cli/commands.h"

#include <memory>

namespace tessera {

void addRedrawCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command =
        program.command("redraw", "Draw a picture again from its own manifest, and say what differs");
    auto a = std::make_shared<RedrawArguments>();
    command.option("FIGURE", a->figure, "picture that tessera made").required();
    command.option("-o,--output", a->out,
                   "picture to write (default: none; the new picture is compared with FIGURE, not kept)");
    command
        .option("--data", a->data,
                "a store or source files of a volume, labels, a mesh or an environment of the picture, in "
                "the order of its scene; may be repeated (default: found by content beside FIGURE or in the "
                "cache of imports)")
        .oneValueEach();
    command
        .option("--with", a->changes,
                "KEY=VALUE: change a key of the scene, such as camera.view=left or window=40,400; may be "
                "repeated")
        .oneValueEach();
    command.option("--path", a->path,
                   "another path of an unfolded wall or a reformation (default: the line that its manifest "
                   "has)");
    command.option("--engine", a->engine, "another engine (default: as it was)");
    command.option("--gl-device", a->device, "auto, software, or a device's number (default: as it was)");
    command.option("--gpu-memory", a->gpuMemory, "another budget (default: as it was)");
    command.option("--ram", a->ram, "another budget (default: as it was)");
    command.flag("--json", a->json, "print what differs as JSON");
    command.footer("Exit code 1 if pixels differ though nothing that is known does.\nExample:\n  tessera "
                   "redraw liver.png --data abdomen.zarr -o again.png --with camera.view=left");
    command.whenChosen([a, &common, &action] { action = [a, &common] { runRedraw(*a, common); }; });
}

} // namespace tessera

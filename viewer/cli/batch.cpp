// viewer/cli/batch.cpp: `tessera batch TABLE.csv`: a picture for each row of a table.
#include "viewer/cli/batch/run_batch.h"

#include "core/base/names.h"
#include "render/engine_traits.h"
#include "render/verify/verify_plan.h" // verifyNames
#include "viewer/cli/commands.h"
#include "viewer/cli/render/layers.h"

#include <memory>

namespace tessera {

void addBatchCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command("batch", "Draw a picture for each row of a table");
    auto a = std::make_shared<BatchArguments>();
    command
        .option(
            "TABLE", a->table,
            "table (.csv): its columns are keys of the scene (camera.view, volumes[0].path), options that "
            "set one (window), or names for -o and the scene's texts")
        .required();
    command.option("--scene", a->scene,
                   "scene (.json), store or source files that every row changes (default: a column "
                   "volumes[0].path has the volume)");
    command
        .option("-o,--output", a->out,
                "the rows' pictures, such as out/{id}.png: {id} is a row's cell of that column, {row} its "
                "number")
        .required();
    command.option("--report", a->report,
                   "record of every row, written as it ends: .csv, or .json for a JSON object a line");
    command.option("--jobs", a->jobs, "rows at once (default: by --ram and the size of pictures)")
        .check(numberWithin(1, 4096, "rows at once from 1 to 4096"))
        .check(wholeNumberFrom(1));
    command.flag("--again", a->again, "draw pictures again that are there and unchanged");
    command
        .flag("--claim", a->claim,
              "share the rows with other processes that run the same command, on this machine or others")
        .excludes("--again");
    command.flag("--dry-run", a->dryRun, "check all rows and say what would be drawn");
    command
        .option("--engine", a->engine, joinNames(engineNames()) + "; auto: gpu if there is one, else native")
        .showsDefault();
    command.option("--verify", a->verify,
                   "draw some pixels again at full accuracy and report the pictures' errors: " +
                       joinNames(verifyNames()) + " (default: quick)");
    command.flag("--no-check", a->noCheck, "the same as --verify none");
    command
        .option("--layers", a->layers,
                joinNames(layerNames()) + ", or all: further layers of .exr pictures; separated by commas")
        .oneValueEach();
    command.flag("--allow-damaged", a->allowDamaged, "draw damaged chunks from coarser levels");
    command.option("--gpu-memory", a->gpuMemory, "budget of all rows at once (default: 1 GiB at most)");
    command.option("--ram", a->ram, "budget of all rows at once (default: 1 GiB at most)");
    command.option("--gl-device", a->device, "auto, software, or a device's number").showsDefault();
    command.flag("--json", a->json, "print the summary as JSON");
    command.footer("Exit code 1 if any row failed.\nExample:\n  tessera batch scans.csv --scene bone.json -o "
                   "'out/{id}.png' --report out/record.csv");
    command.whenChosen([a, &common, &action] { action = [a, &common] { runBatch(*a, common); }; });
}

} // namespace tessera

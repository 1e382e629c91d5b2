// viewer/cli/phantom.cpp: `tessera phantom NAME --size XxYxZ -o OUT.zarr`: a generated volume, streamed.
#include "datasets/phantom.h"
#include "bricking/import/importer.h"
#include "core/base/magnitude.h"
#include "core/base/names.h"
#include "core/base/output_file.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/input/volume_input.h"

#include <memory>

namespace tessera {
namespace {

constexpr int kMaxExtent = 65536; // voxels an axis: 2^48 in all, far beyond any disk

struct PhantomArguments {
    std::string name, size = "128x128x128", out, ram, curves;
    bool force = false;
};

void runPhantom(const PhantomArguments& arguments, const CommonOptions& common) {
    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const glm::ivec3 extent = parseVolumeSize(arguments.size, "--size", kMaxExtent);
    const auto source = makePhantom(arguments.name, extent);
    const std::filesystem::path out(arguments.out);
    requireStorePath(out, arguments.force);
    const std::string curves = arguments.curves.empty() ? std::string() : phantomCurvesJson(arguments.name);
    if (!arguments.curves.empty())
        checkOutputFile(arguments.curves);
    common.detail("making " + source->describe() + " in " + out.string());
    ImportOptions options;
    options.force = arguments.force;
    options.progress = common.progress.get();
    noteImport(importToStore(*source, out, ram, options), *source, out, ram, common);
    if (!arguments.curves.empty())
        writeOutputFile(arguments.curves, curves);
}

} // namespace

void addPhantomCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command("phantom", "Generate a volume of any size, streamed into a store");
    auto arguments = std::make_shared<PhantomArguments>();
    command.option("NAME", arguments->name, "one of " + joinNames(phantomNames()))
        .required()
        .offers(phantomNames());
    command.option("--size", arguments->size, "voxels, XxYxZ").showsDefault();
    command.option("-o,--output", arguments->out, "store to write, OUT.zarr").required();
    command.option(
        "--curves", arguments->curves,
        "for a torso: write the centre-lines of colon, airways and aorta, and the polyps, as JSON");
    command.flag("--force", arguments->force, "replace an existing store");
    command.option("--ram", arguments->ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    command.footer("Example:\n  tessera phantom torso --size 256x192x300 -o torso.zarr");
    command.whenChosen(
        [arguments, &common, &action] { action = [arguments, &common] { runPhantom(*arguments, common); }; });
}

} // namespace tessera

// viewer/cli/centreline.cpp: `tessera centreline STORE --from x,y,z --to x,y,z -o path.json`: the middle
// of a hollow organ as a path that can be flown and filmed.
#include "bricking/analysis/lumen/centreline.h"
#include "bricking/store/store_reader.h"
#include "core/base/error.h"
#include "core/base/output_file.h"
#include "core/base/shown_text.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/input/volume_input.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace tessera {
namespace {

constexpr double kMostMm = 1e7;

struct CentrelineArguments {
    std::string in, from, to, out, ram;
    std::vector<std::string> through;
    double threshold = std::numeric_limits<double>::quiet_NaN(), spacing = 1;
    bool tree = false, mayLeak = false;
    int generations = 12;
    InputOptions input;
};

/// "12.5,-40,103": patient space, mm.
glm::dvec3 parsePlace(const std::string& text, const std::string& option) {
    const std::optional<std::vector<double>> mm = lengthsOf(text, 3);
    if (!mm || !std::ranges::all_of(*mm, [](double one) { return std::abs(one) <= kMostMm; }))
        throw badFile(option, "a point as x,y,z, millimetres in patient space", "'" + text + "'");
    return {(*mm)[0], (*mm)[1], (*mm)[2]};
}

CentrelineRequest requestOf(const CentrelineArguments& arguments) {
    CentrelineRequest request;
    if (arguments.tree && (!arguments.to.empty() || !arguments.through.empty()))
        throw badFile("--tree", "--from alone, the tree's root", "--to or --through as well");
    request.seeds.push_back({parsePlace(arguments.from, "--from"), "--from"});
    for (const std::string& text : arguments.through)
        request.seeds.push_back({parsePlace(text, "--through"), "--through " + text, true});
    if (!arguments.to.empty())
        request.seeds.push_back({parsePlace(arguments.to, "--to"), "--to"});
    else if (!arguments.through.empty())
        throw badFile("--through", "--to as well, where the path ends", "--through alone");
    if (!std::isnan(arguments.threshold))
        request.threshold = arguments.threshold;
    if (arguments.mayLeak && !request.threshold)
        throw badFile("--may-leak", "--threshold with it, which it keeps", "none");
    request.mayLeak = arguments.mayLeak;
    request.tree = arguments.tree;
    request.mostGenerations = arguments.generations;
    request.spacingMm = arguments.spacing;
    return request;
}

void tell(const Centrelines& found, const VolumeInfo& info, const Path& path, const std::string& out,
          const CommonOptions& common) {
    const LinesExtent extent = extentOf(path.lines);
    common.note(lumenText(found, info.unit) + (found.evidence.leaksAt && found.evidence.given
                                                   ? "; --may-leak keeps it"
                                                   : "; --threshold sets it"));
    for (const CentrelineBridge& bridge : found.bridges)
        common.note("bridged: a gap of " + formatNumber(glm::length(bridge.toMm - bridge.fromMm)) + " mm");
    common.note("wrote " + out + ": " +
                (path.lines.size() == 1 ? "a path" : std::to_string(path.lines.size()) + " branches") +
                " of " + mmText(extent.lengthMm) + ", " + mmText(extent.narrowestMm) + " to " +
                mmText(extent.widestMm) + " from the wall, " +
                (std::isfinite(found.leastTurnMm)
                     ? "turns of " + formatNumber(found.leastTurnMm) + " mm and more"
                     : "without a turn"));
    common.detail(std::to_string(found.lumenVoxels) + " voxels of lumen, searched in blocks of " +
                  std::to_string(found.blockVoxels) + " voxels");
}

void runCentreline(const CentrelineArguments& arguments, const CommonOptions& common) {
    const CentrelineRequest request = requestOf(arguments);
    if (!arguments.out.ends_with(".json"))
        throw badFile("--output", "a file that ends in .json", "'" + arguments.out + "'");
    checkOutputFile(arguments.out);
    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const StoreReader store(storeFor(arguments.in, arguments.input, ram, common), ram);
    const Centrelines found = findCentrelines(store, request, ram, *common.progress);
    Path path;
    path.volume = {store.contentHash(), store.info().extentVoxels};
    path.lumen = found.lumen;
    path.lines = found.lines;
    checkPath(path, arguments.out);
    writeOutputFile(arguments.out, pathJson(path));
    tell(found, store.info(), path, arguments.out, common);
    common.detail("RAM: " + formatBytes(ram.peakBytes()) + " of " + formatBytes(ram.limitBytes()));
}

} // namespace

void addCentrelineCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command(
        "centreline",
        "Find the centre-line of a hollow organ (colon, airways, aorta) as a path to fly along");
    auto arguments = std::make_shared<CentrelineArguments>();
    command.option("IN", arguments->in, "store, or source files").required();
    command.option("--from", arguments->from, "start: x,y,z in the lumen, patient space, mm").required();
    command.option("--to", arguments->to, "end (default: the point furthest from --from)");
    command
        .option("--through", arguments->through,
                "a point on the way, beside or in a gap, which is then bridged; may be repeated")
        .oneValueEach();
    command
        .option("--threshold", arguments->threshold,
                "value at which the lumen ends, physical units; tightened if it leaks (default: half way to "
                "the wall, by values around the seeds)")
        .check(numberWithin(-1e30, 1e30, "a value"));
    command.flag("--may-leak", arguments->mayLeak, "with --threshold: keep it even if the lumen leaks");
    command.flag("--tree", arguments->tree, "all branches beyond --from, such as airways from the windpipe");
    command
        .option("--generations", arguments->generations,
                "with --tree: most forks between --from and a branch")
        .showsDefault()
        .check(wholeNumberFrom(0));
    command.option("--spacing", arguments->spacing, "largest distance between the path's points, mm")
        .inUnit("mm")
        .showsDefault()
        .check(numberWithin(0.05, 100, "mm from 0.05 to 100"));
    command.option("-o,--output", arguments->out, "path to write, OUT.json").required();
    command.option("--ram", arguments->ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    addSelectionOptions(command, arguments->input);
    command.footer("Example:\n  tessera centreline thorax.zarr --from 0,8,180 --tree -o airways.json");
    command.whenChosen([arguments, &common, &action] {
        action = [arguments, &common] { runCentreline(*arguments, common); };
    });
}

} // namespace tessera

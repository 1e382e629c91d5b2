// viewer/cli/coverage.cpp: `tessera coverage STORE --path path.json`: what share of a hollow organ's
// wall a flight along its line sees, and where it does not.
#include "bricking/analysis/lumen/wall_coverage.h"
#include "bricking/store/store_reader.h"
#include "core/animation/flight.h"
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "core/base/output_file.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/paths/path_file.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

namespace tessera {
namespace {

struct CoverageArguments {
    std::string in, path, size = "640x480", out, ram;
    double viewAngle = 0, every = 1, farthest = 0, smallest = 25; // 0: as the path says; no limit
    bool backwards = false, bothWays = false, json = false;
    InputOptions input;
};

/// The path as the options have it, made in this volume.
Path pathOf(const CoverageArguments& a, const StoreReader& store) {
    Path path = loadPathFile(a.path);
    if (path.lines.empty() || !path.lumen)
        throw badFile(a.path, "a path with a line and its lumen, as tessera centreline writes it",
                      path.lines.empty() ? "no line" : "no \"lumen\"");
    if (path.volume && path.volume->contentHash != store.contentHash())
        throw badFile(
            a.path, "a path made in this volume, of " + formatExtent(store.info().extentVoxels) + " voxels",
            "one made in another volume, of " + formatExtent(path.volume->extentVoxels) + " voxels");
    if (!path.flight)
        path.flight = Flight{};
    if (a.backwards && !path.flight->backwards)
        path = flownTheOtherWay(std::move(path));
    if (a.viewAngle > 0)
        path.flight->viewAngle = a.viewAngle;
    return path;
}

nlohmann::json reportOf(const CoverageArguments& a, const CoverageRequest& request,
                        const WallCoverage& found) {
    nlohmann::json patches = nlohmann::json::array();
    for (const UnseenPatch& p : found.patches)
        patches.push_back({{"middle", {p.middleMm.x, p.middleMm.y, p.middleMm.z}},
                           {"areaMm2", p.areaMm2},
                           {"alongMm", p.alongMm},
                           {"fromMm", p.fromMm},
                           {"toMm", p.toMm}});
    nlohmann::json out = {{"path", a.path},
                          {"share", found.share()},
                          {"wallMm2", found.wallMm2},
                          {"seenMm2", found.seenMm2},
                          {"faces", found.faces},
                          {"lines", found.lines},
                          {"route", request.flight.route},
                          {"cameras", request.cameras.size()},
                          {"camerasOutsideTheLumen", found.blind},
                          {"viewAngle", request.flight.viewAngle},
                          {"aspect", request.aspect},
                          {"backwards", request.flight.backwards},
                          {"bothWays", a.bothWays},
                          {"smallestPatchMm2", request.smallestPatchMm2},
                          {"patches", std::move(patches)}};
    out["farthestMm"] = a.farthest > 0 ? nlohmann::json(a.farthest) : nlohmann::json();
    return out;
}

void runCoverage(const CoverageArguments& arguments, const CommonOptions& common) {
    const glm::ivec2 size = parseImageSize(arguments.size, "--size", Scene::kMaxImageExtent);
    if (!arguments.out.empty()) {
        if (!arguments.out.ends_with(".json"))
            throw badFile("--output", "a file that ends in .json", "'" + arguments.out + "'");
        checkOutputFile(arguments.out);
    }
    MemoryBudget ram("RAM", "--ram", budgetBytes(arguments.ram, "--ram", common));
    const StoreReader store(storeFor(arguments.in, arguments.input, ram, common), ram);
    const Path path = pathOf(arguments, store);
    CoverageRequest request;
    request.lines = path.lines;
    request.flight = *path.flight;
    request.lumen = *path.lumen;
    request.cameras = flightCameras(path, arguments.every, arguments.bothWays);
    request.aspect = static_cast<double>(size.x) / size.y;
    if (arguments.farthest > 0)
        request.farthestMm = arguments.farthest;
    request.smallestPatchMm2 = arguments.smallest;
    request.where = arguments.path;
    const WallCoverage found = measureWallCoverage(store, request, ram, *common.progress);
    const std::string text =
        reportOf(arguments, request, found).dump(2, ' ', true, nlohmann::json::error_handler_t::replace);
    if (!arguments.out.empty())
        writeOutputFile(arguments.out, text + "\n");
    std::printf("%s\n",
                arguments.json ? text.c_str() : coverageText(found, request.smallestPatchMm2).c_str());
    finishStandardOutput();
    if (!arguments.out.empty())
        common.note("wrote " + arguments.out + ": " + std::to_string(found.patches.size()) +
                    " unseen patches");
    common.detail(std::to_string(found.faces) + " faces of wall, " + std::to_string(request.cameras.size()) +
                  " cameras, " + std::to_string(found.blind) + " of them outside the lumen");
    common.detail("RAM: " + formatBytes(ram.peakBytes()) + " of " + formatBytes(ram.limitBytes()));
}

} // namespace

void addCoverageCommand(Command& program, const CommonOptions& common, Action& action) {
    Command command = program.command(
        "coverage", "Report the share of a hollow organ's wall that a flight sees, and the unseen patches");
    auto arguments = std::make_shared<CoverageArguments>();
    command.option("IN", arguments->in, "store, or source files").required();
    command.option("--path", arguments->path, "the path, as tessera centreline writes it").required();
    command.option("--size", arguments->size, "size of the pictures; only its aspect ratio matters")
        .showsDefault();
    command
        .option("--view-angle", arguments->viewAngle, "vertical angle of view, degrees (default: the path's)")
        .check(numberWithin(1, Path::kMostViewAngle, "degrees from 1 to 170"));
    command.option("--every", arguments->every, "largest distance between pictures, mm")
        .inUnit("mm")
        .showsDefault()
        .check(numberWithin(0.05, 1000, "mm from 0.05 to 1000"));
    command.flag("--backwards", arguments->backwards, "fly from the route's end to its beginning");
    command.flag("--both-ways", arguments->bothWays, "fly there and back, and count what either flight sees");
    command
        .option("--farthest", arguments->farthest,
                "distance from the eye, mm, beyond which wall is not seen (default: unlimited)")
        .inUnit("mm")
        .check(numberWithin(0.1, 1e6, "mm from 0.1 to 1e6"));
    command.option("--smallest", arguments->smallest, "smallest unseen patch that is listed, mm2")
        .inUnit("mm2")
        .showsDefault()
        .check(numberWithin(0, 1e9, "mm2 from 0 to 1e9"));
    command.option("-o,--output", arguments->out, "report to write, OUT.json: all unseen patches");
    command.flag("--json", arguments->json, "the report on standard output");
    command.option("--ram", arguments->ram, "budget, e.g. 512MiB (default: 1 GiB at most)");
    addSelectionOptions(command, arguments->input);
    addSpacingOption(command, arguments->input);
    command.footer("Example:\n  tessera coverage colon.zarr --path colon.json --both-ways -o unseen.json");
    command.whenChosen([arguments, &common, &action] {
        action = [arguments, &common] { runCoverage(*arguments, common); };
    });
}

} // namespace tessera

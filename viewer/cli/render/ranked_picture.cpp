// viewer/cli/render/ranked_picture.cpp: see ranked_picture.h.
#include "viewer/cli/render/ranked_picture.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"
#if TESSERA_WITH_ICET
#include "viewer/ranks/mpi_group.h"
#endif

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace tessera {
namespace {

constexpr const char* kRanksOption = "--ranks";

#if !TESSERA_WITH_ICET
ProcessGroup& joinRanks() {
    throw badFile(kRanksOption, "a program with MPI and IceT (built with -DTESSERA_WITH_ICET=ON)",
                  "one without");
}
#endif

} // namespace

void renderInGroup(const CommonOptions& common,
                   const std::function<void(const CommonOptions& mine, ProcessGroup& group)>& render) {
    ProcessGroup& group = joinRanks();
    CommonOptions mine = common;
    if (group.rank() > 0) { // what is to be said number 0 says
        mine.quiet = true;
        mine.progress = std::make_shared<Progress>(mine.verbosity());
    }
    try {
        render(mine, group);
    } catch (const InputError&) {
        group.fail(2);
        throw;
    } catch (const Interrupted& interrupted) {
        group.fail(interrupted.exitCode());
        throw;
    } catch (...) {
        group.fail(1);
        throw;
    }
}

void checkRanks(const RenderArguments& arguments) {
    if (arguments.isFilm() || !arguments.pathPicture().empty())
        throw badFile(kRanksOption, "one picture", arguments.isFilm() ? "a film" : arguments.pathPicture());
    for (const auto& [said, option] : {std::pair{arguments.tiles > 0, "--tiles"},
                                       {!arguments.first.empty(), "--first"},
                                       {!arguments.layers.empty(), "--layers"},
                                       {!arguments.keepState.empty(), "--keep-state"},
                                       {arguments.allowDamaged, "--allow-damaged"}})
        if (said)
            throw badFile(kRanksOption, std::string("no ") + option + " with it", option);
    if (!arguments.verify.empty() && verifyOf(arguments) != Verify::none)
        throw badFile(kRanksOption, "--verify none, because no process has the bricks of a better picture",
                      arguments.verify);
}

EngineKind engineOfRanks(EngineKind asked) {
    if (asked == EngineKind::automatic)
        return EngineKind::native;
    if (!traitsOf(asked).drawsParts)
        throw badFile("--engine", "native with --ranks", name(asked));
    return asked;
}

nlohmann::json ranksJson(const RenderTask& task, const RenderResult& result) {
    const auto three = [](const glm::ivec3& v) { return nlohmann::json{v.x, v.y, v.z}; };
    nlohmann::json ranks;
    for (const PartReport& part : task.options.group->gather(
             {result.part, result.work.bytesUploaded, task.ram.peakBytes(), task.gpu.peakBytes()}))
        ranks.push_back({{"bricks", {three(part.box.low), three(part.box.high)}},
                         {"bytesOfBricks", part.bytesOfBricks},
                         {"ramPeakBytes", part.ramPeak},
                         {"gpuPeakBytes", part.gpuPeak}});
    return ranks;
}

} // namespace tessera

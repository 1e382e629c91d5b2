// viewer/cli/render/ranked_picture.h: `tessera render --ranks`: one picture by the processes that mpirun
// started, each of which holds a part of the volume.
#pragma once

#include "render/parts/process_group.h"
#include "viewer/cli/render/render_task.h"

#include <functional>
#include <nlohmann/json_fwd.hpp>

namespace tessera {

/// Calls render() in this process's group; of all but number 0 quietly. Where it throws, all processes end.
/// Throws Error where the program was built without MPI.
void renderInGroup(const CommonOptions& common,
                   const std::function<void(const CommonOptions& mine, ProcessGroup& group)>& render);

/// Throws InputError naming an option that --ranks cannot be combined with.
void checkRanks(const RenderArguments& arguments);
/// The engine that draws parts. Throws InputError for another that was named.
EngineKind engineOfRanks(EngineKind asked);

/// The manifest's "ranks", at number 0: what every process held. Null elsewhere; all processes call it.
nlohmann::json ranksJson(const RenderTask& task, const RenderResult& result);

} // namespace tessera

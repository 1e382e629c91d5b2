// viewer/cli/batch/done_before.h: whether a picture is there already, of the same scene, data, options and
// program.
#pragma once

#include "core/base/budget.h"
#include "viewer/cli/render/scene_from_arguments.h"

#include <filesystem>

namespace tessera {

enum class DoneCheck {
    imports, // what the scene names is imported where it must be, to compare its content
    asItIs   // what is not imported counts as changed
};

/// True if the output's manifest tells that drawing it again would give the same. Budgets and processors do
/// not count.
/// @param arguments  with a scene
/// Throws InputError as applyArguments() and storeFor() do.
bool isDoneBefore(const std::filesystem::path& output, const RenderArguments& arguments, DoneCheck check,
                  MemoryBudget& ram, const CommonOptions& common);

} // namespace tessera

// viewer/cli/commands.h: the commands of the program, one file each. A command declares its options.
// Once chosen and parsed it stores its work in `action`, so errors of parsing and of running stay separate.
#pragma once

#include "viewer/cli/options/run_commands.h"

#include <memory>

namespace tessera {

struct RenderArguments;
/// The options of `tessera render` alone, for what draws without the command (viewer/python/).
void addRenderOptions(Command& command, const std::shared_ptr<RenderArguments>& arguments);

void addBatchCommand(Command& program, const CommonOptions& common, Action& action);
void addCentrelineCommand(Command& program, const CommonOptions& common, Action& action);
void addCoverageCommand(Command& program, const CommonOptions& common, Action& action);
void addExportCommand(Command& program, const CommonOptions& common, Action& action);
void addImportCommand(Command& program, const CommonOptions& common, Action& action);
void addInfoCommand(Command& program, const CommonOptions& common, Action& action);
void addMeshCommand(Command& program, const CommonOptions& common, Action& action);
void addRedrawCommand(Command& program, const CommonOptions& common, Action& action);
void addRenderCommand(Command& program, const CommonOptions& common, Action& action);
void addPhantomCommand(Command& program, const CommonOptions& common, Action& action);
void addPresetCommand(Command& program, const CommonOptions& common, Action& action);
void addCacheCommand(Command& program, const CommonOptions& common, Action& action);
void addValidateCommand(Command& program, const CommonOptions& common, Action& action);
void addCompletionCommand(Command& program, const CommonOptions& common, Action& action);
void addManCommand(Command& program, const CommonOptions& common, Action& action);
void addViewCommand(Command& program, const CommonOptions& common, Action& action); // TESSERA_WITH_WINDOW

} // namespace tessera

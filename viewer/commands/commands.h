// viewer/commands/commands.h: the commands of the program, one file each. A command declares its options;
// when it was chosen and parsed it leaves what is to be done in `action`, so that errors of parsing and of
// doing stay apart.
#pragma once

#include "viewer/options/options.h"

#include <functional>

namespace CLI {
class App;
}

namespace tessera {

using Action = std::function<void()>;

void addCentrelineCommand(CLI::App& program, const CommonOptions& common, Action& action);
void addCoverageCommand(CLI::App& program, const CommonOptions& common, Action& action);
void addImportCommand(CLI::App& program, const CommonOptions& common, Action& action);
void addInfoCommand(CLI::App& program, const CommonOptions& common, Action& action);
void addRenderCommand(CLI::App& program, const CommonOptions& common, Action& action);
void addPhantomCommand(CLI::App& program, const CommonOptions& common, Action& action);
void addAccuracyCommand(CLI::App& program, const CommonOptions& common, Action& action);
void addPresetCommand(CLI::App& program, const CommonOptions& common, Action& action);
void addCacheCommand(CLI::App& program, const CommonOptions& common, Action& action);
void addViewCommand(CLI::App& program, const CommonOptions& common, Action& action); // TESSERA_WITH_WINDOW
void addBenchCommand(CLI::App& program, const CommonOptions& common, Action& action);

} // namespace tessera

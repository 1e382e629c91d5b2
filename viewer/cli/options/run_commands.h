// viewer/cli/options/run_commands.h: a program of commands: parses, runs one, and turns errors into one line
// and an exit code.
#pragma once

#include "viewer/cli/options/command.h"
#include "viewer/cli/options/options.h"

#include <functional>

namespace tessera {

/// The work of the chosen command, so that errors of parsing and of running stay separate.
using Action = std::function<void()>;
/// Declares commands.
using AddCommands = void (*)(Command& program, const CommonOptions& common, Action& action);

/// @return the exit code: 0 success, 2 bad use or bad input, 128 and the signal's number after a signal, 1
/// anything else
int runCommands(int argc, char** argv, AddCommands addCommands);

} // namespace tessera

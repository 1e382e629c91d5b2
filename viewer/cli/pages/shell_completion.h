// viewer/cli/pages/shell_completion.h: scripts that complete a program's commands, options and their words in
// a shell, from its table of commands.
#pragma once

#include "viewer/cli/options/command_table.h"

#include <string>
#include <vector>

namespace tessera {

/// {"bash", "zsh"}
const std::vector<std::string>& completedShells();
/// Throws InputError naming `shell` for another one.
std::string shellCompletion(const CommandRow& program, const std::string& shell);

} // namespace tessera

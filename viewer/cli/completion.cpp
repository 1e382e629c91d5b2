// viewer/cli/completion.cpp: `tessera completion bash`: the script that completes commands and options in a
// shell.
#include "core/base/names.h"
#include "viewer/cli/commands.h"
#include "viewer/cli/pages/shell_completion.h"

#include <cstdio>
#include <memory>
#include <string>

namespace tessera {

void addCompletionCommand(Command& program, const CommonOptions&, Action& action) {
    Command command =
        program.command("completion", "Print the script that completes commands and options in a shell");
    const auto shell = std::make_shared<std::string>();
    command.option("SHELL", *shell, joinNames(completedShells())).required().offers(completedShells());
    command.footer("Packages install it. Elsewhere:\nExample:\n  source <(tessera completion bash)");
    command.whenChosen([shell, program, &action] {
        action = [shell, program] { std::fputs(shellCompletion(program.table(), *shell).c_str(), stdout); };
    });
}

} // namespace tessera

// viewer/input/selection_options.h: the options by which source files are chosen, the same for every command.
#pragma once

#include "viewer/input/volume_input.h"

namespace CLI {
class App;
}

namespace tessera {

void addSelectionOptions(CLI::App& command, InputOptions& input);

} // namespace tessera

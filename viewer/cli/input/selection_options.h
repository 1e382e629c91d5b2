// viewer/cli/input/selection_options.h: the options that choose among source files, the same for every
// command.
#pragma once

#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/options/command.h"

namespace tessera {

void addSelectionOptions(Command& command, InputOptions& input);

} // namespace tessera

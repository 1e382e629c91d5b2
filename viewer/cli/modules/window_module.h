// viewer/cli/modules/window_module.h: the functions of viewer/window/run_window.h, as the table of a module.
#pragma once

#include "viewer/cli/modules/load_module.h"
#include "viewer/window/run_window.h"

namespace tessera {

struct WindowModule {
    ModuleHead head;
    decltype(&runWindow) run;
};

} // namespace tessera

// viewer/cli/modules/window_on_demand.cpp: viewer/window/run_window.h for programs: the first window loads
// what shows it.
#include "viewer/cli/modules/window_module.h"

namespace tessera {

void runWindow(const WindowOptions& options) {
    static const auto* const module = static_cast<const WindowModule*>(loadModule("tessera_window_module"));
    module->run(options);
}

} // namespace tessera

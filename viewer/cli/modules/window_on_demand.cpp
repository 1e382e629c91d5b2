// viewer/cli/modules/window_on_demand.cpp: viewer/window/run_window.h for programs: the first window loads
// what shows it.
#include "core/base/error.h"
#include "viewer/cli/modules/window_module.h"

#include <string>

namespace tessera {
namespace {

const WindowModule& windowModule() {
    try {
        return *static_cast<const WindowModule*>(loadModule("tessera_window_module"));
    } catch (const Error& error) {
        throw Error(std::string(error.what()) + "; the window is a package of its own, tessera-window");
    }
}

} // namespace

void runWindow(const WindowOptions& options) {
    static const WindowModule& module = windowModule();
    module.run(options);
}

} // namespace tessera

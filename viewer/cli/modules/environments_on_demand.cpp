// viewer/cli/modules/environments_on_demand.cpp: core/image/environment_file.h for programs: the first
// environment's file loads what reads it.
#include "viewer/cli/modules/environment_module.h"

namespace tessera {

EnvironmentPixels readEnvironment(const std::filesystem::path& path, MemoryBudget& ram) {
    static const auto* const table =
        static_cast<const EnvironmentModule*>(loadModule("tessera_environments"));
    return table->read(path, ram);
}

} // namespace tessera

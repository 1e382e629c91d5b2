// viewer/cli/modules/environment_module.h: the function of core/image/environment_file.h, as the table of a
// module.
#pragma once

#include "core/image/environment_file.h"
#include "viewer/cli/modules/load_module.h"

namespace tessera {

struct EnvironmentModule {
    ModuleHead head;
    decltype(&readEnvironment) read;
};

} // namespace tessera

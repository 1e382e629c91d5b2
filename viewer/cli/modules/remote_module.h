// viewer/cli/modules/remote_module.h: the function of bricking/remote/http_files.h, as the table of a module.
#pragma once

#include "bricking/remote/http_files.h"
#include "viewer/cli/modules/load_module.h"

namespace tessera {

struct RemoteModule {
    ModuleHead head;
    decltype(&openRemoteFiles) open;
};

} // namespace tessera

// viewer/cli/modules/remote_on_demand.cpp: bricking/remote/http_files.h for programs: the first address loads
// what reads it.
#include "viewer/cli/modules/remote_module.h"

namespace tessera {

std::shared_ptr<RemoteFiles> openRemoteFiles(const std::string& address, const RemoteOptions& options) {
    static const auto* const table = static_cast<const RemoteModule*>(loadModule("tessera_remote_files"));
    return table->open(address, options);
}

} // namespace tessera

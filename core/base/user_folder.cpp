// core/base/user_folder.cpp: see user_folder.h.
#include "core/base/user_folder.h"

#include <cstdlib>

namespace tessera {

std::filesystem::path userConfigFolder() {
    const char* const config = std::getenv("XDG_CONFIG_HOME");
    const char* const home = std::getenv("HOME");
    if (config && *config == '/')
        return std::filesystem::path(config) / "tessera";
    if (home && *home == '/')
        return std::filesystem::path(home) / ".config" / "tessera";
    return {};
}

} // namespace tessera

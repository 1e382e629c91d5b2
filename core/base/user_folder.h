// core/base/user_folder.h: the folder of a user's own files: presets, the window's settings.
#pragma once

#include <filesystem>

namespace tessera {

/// ${XDG_CONFIG_HOME}/tessera, or ~/.config/tessera; empty if neither variable names a folder. It need not
/// exist.
std::filesystem::path userConfigFolder();

} // namespace tessera

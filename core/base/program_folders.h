// core/base/program_folders.h: folders that the program itself has: one for temporary data (generated volumes
// of the benches and of the tests), and that of a user's own files (presets, the window's settings).
#pragma once

#include "core/base/files.h"
#include "core/base/interrupt.h" // TemporaryPath

#include <filesystem>
#include <optional>
#include <string>

namespace tessera {

/// A new folder in the system's temporary folder, for this object and this user only; removed with its
/// content. Folders of dead processes are removed when another one is made.
class ScratchFolder {
  public:
    /// Throws Error naming the path if no folder can be made.
    ScratchFolder();
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  private:
    std::filesystem::path path_;
    FileHandle owned_;
    std::optional<TemporaryPath> unfinished_;
};

/// ${XDG_CONFIG_HOME}/tessera, or ~/.config/tessera; empty if neither variable names a folder. It need not
/// exist.
std::filesystem::path userConfigFolder();

} // namespace tessera

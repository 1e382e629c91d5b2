// viewer/window/settings.h: the settings that the window remembers: its size and the files opened last.
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <vector>

namespace tessera {

struct Settings {
    static constexpr std::size_t kMostRecent = 12;
    glm::ivec2 windowSize{0};                  // 0: none remembered
    std::vector<std::filesystem::path> recent; // the last opened first
    std::filesystem::path folder;              // that the browser showed last; empty: none
    bool panels = true;

    /// The path becomes the first of the recent ones.
    void opened(const std::filesystem::path& path);
};

/// ${XDG_CONFIG_HOME}/tessera/window.json, or ~/.config/tessera/window.json; empty where there is no such
/// folder to be.
std::filesystem::path settingsFile();
/// As the file says; what it lacks or has wrong is as it is at first. A window is never refused
/// for its settings.
Settings loadSettings(const std::filesystem::path& file);
/// Writes the file and its folder. Returns what went wrong; empty: nothing.
std::string saveSettings(const Settings& settings, const std::filesystem::path& file);

} // namespace tessera

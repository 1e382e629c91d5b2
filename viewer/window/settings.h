// viewer/window/settings.h: the saved settings of the window: its size and recent files.
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <vector>

namespace tessera {

struct Settings {
    static constexpr std::size_t kMostRecent = 12;
    glm::ivec2 windowSize{0};                  // 0: none saved
    std::vector<std::filesystem::path> recent; // most recent first
    std::filesystem::path folder;              // last folder of the browser; empty: none
    bool panels = true;

    /// Makes the path the first of the recent ones.
    void opened(const std::filesystem::path& path);
};

/// ${XDG_CONFIG_HOME}/tessera/window.json, or ~/.config/tessera/window.json; empty without either variable.
std::filesystem::path settingsFile();
/// Reads the file; missing or invalid settings get defaults, without an error.
Settings loadSettings(const std::filesystem::path& file);
/// Writes the file and its folder. Returns the error; empty: none.
std::string saveSettings(const Settings& settings, const std::filesystem::path& file);

} // namespace tessera

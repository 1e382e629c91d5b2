// viewer/window/run_window.h: the window: input goes to a Viewing, and its results are shown. It draws no
// volume itself. Everything that it shows is a scene (viewer/session/viewing.h).
#pragma once

#include "core/scene/scene_presets.h"
#include "viewer/session/viewing.h"

#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

// Access to presets that are not built in, for the window, which itself reads and writes no files.

/// All of these throw Error or InputError, with a sentence for the user.
struct PresetShelf {
    /// Names of the user's presets.
    std::function<std::vector<std::string>()> names;
    /// One of those, or of a file; unsupported settings go to leftOut, a sentence each.
    std::function<Preset(const std::string& nameOrFile, std::vector<std::string>& leftOut)> find;
    /// Keeps it under its name.
    std::function<void(const Preset&)> keep;
    /// Writes it: ours, or, by the format's name, Slicer's or ParaView's. Returns the settings left out.
    std::function<std::vector<std::string>(const Preset&, const std::filesystem::path&,
                                           const std::string& format)>
        write;
};

struct WindowOptions {
    static constexpr int kFirstSize[2] = {1280, 720};
    std::filesystem::path path; // opened at once; empty: none
    /// Another scan, shown at its right with the same camera and look; empty: none.
    std::filesystem::path beside = {};
    /// Size of the window, in the screen's units; none: the last size, else kFirstSize.
    std::optional<glm::ivec2> size;
    std::optional<std::filesystem::path> script; // script of input (script.h)
    bool panels = true;
    PresetShelf presets;
    /// Makes a Viewing, and with `beside` another. The function passed to it may be called from any thread
    /// when there is news.
    std::function<std::unique_ptr<Viewing>(std::function<void()>)> makeViewing;
};

/// Shows the window until it is closed. Call it on the program's main thread. Throws Error if no window can
/// be opened, and InputError for an invalid script, naming file and line.
void runWindow(const WindowOptions& options);

} // namespace tessera

// viewer/window/run_window.h: the window: input goes to a Viewing, and its results are shown. It draws no
// volume itself. Whatever it can show, a scene can (viewer/session/viewing.h).
#pragma once

#include "viewer/session/viewing.h"
#include "viewer/window/preset_shelf.h"

#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>

namespace tessera {

struct WindowOptions {
    static constexpr int kFirstSize[2] = {1280, 720};
    std::filesystem::path path; // opened at once; empty: none
    /// Of the window, in the screen's units; none: as it was last, else kFirstSize.
    std::optional<glm::ivec2> size;
    std::optional<std::filesystem::path> script; // what to do, instead of a hand (script.h)
    bool panels = true;
    PresetShelf presets;
    /// Makes what draws. The function that it gets is to be called from any thread when there is news.
    std::function<std::unique_ptr<Viewing>(std::function<void()>)> makeViewing;
};

/// Shows the window until it is closed. On the thread that it is called on, which must be the program's
/// first. Throws Error where no window can be opened, and InputError for a script with a mistake, naming file
/// and line.
void runWindow(const WindowOptions& options);

} // namespace tessera

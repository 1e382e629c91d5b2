// tests/support/desk.h: the state of a window at an open volume, without a window.
#pragma once

#include "tests/support/pretended_viewing.h"
#include "viewer/window/window_state.h"

#include <memory>

namespace tessera::test {

/// An open volume, and the desk at it.
struct Desk {
    explicit Desk(const glm::ivec2& size = {400, 300}) {
        viewing.opened(size);
        viewing.drawn.reset();
        desk.setPictureSize(size);
        desk.update();
    }
    /// Draws what was asked for last.
    void draw() {
        if (!viewing.drawn)
            viewing.drawn = std::make_shared<ShownPicture>();
        viewing.draw();
        desk.update();
    }
    PretendedViewing viewing;
    Settings settings;
    PresetShelf presets;
    WindowState desk{viewing, settings, presets};
};

} // namespace tessera::test

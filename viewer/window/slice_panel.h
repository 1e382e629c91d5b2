// viewer/window/slice_panel.h: the three planes beside the volume, linked by a crosshair, with mouse and keys
// on them.
#pragma once

#include "viewer/window/endoscopy.h"
#include "viewer/window/picture_view.h" // Area
#include "viewer/window/tools.h"
#include "viewer/window/window_state.h"

#include <array>
#include <memory>

namespace tessera {

class SlicePanel {
  public:
    SlicePanel();
    ~SlicePanel();
    SlicePanel(const SlicePanel&) = delete;
    SlicePanel& operator=(const SlicePanel&) = delete;
    /// Draws them into the area, one above the other, and handles input there. While ImGui's frame is open.
    void draw(WindowState& desk, Tools& tools, Endoscopy& endoscopy, const Area& area);
    /// The border between picture and planes, which is dragged.
    /// @param picture, planes  side by side
    /// Returns true if it takes the mouse.
    bool divide(WindowState& desk, const Area& picture, const Area& planes);

  private:
    void hand(WindowState& desk, Tools& tools, Endoscopy& endoscopy, const Area& view, int plane,
              const SliceFrame& frame);

    std::array<unsigned, 3> textures_{};
    std::shared_ptr<const ShownSlices> shown_;
    int held_ = -1;        // plane under a button that is down
    bool windows_ = false; // it changes the window, not the crosshair
    bool divides_ = false;
};

} // namespace tessera

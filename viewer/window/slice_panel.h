// viewer/window/slice_panel.h: the three planes beside the volume, linked by a crosshair, with mouse and keys
// on them.
#pragma once

#include "viewer/window/endoscopy.h"
#include "viewer/window/picture_view.h" // Area
#include "viewer/window/tools.h"
#include "viewer/window/window_state.h"

#include <array>
#include <cstddef>
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
    /// Those of the other scan, through the same place. A hand there moves both crosshairs.
    void drawBeside(WindowState& desk, Beside& beside, const Area& area);
    /// The border between picture and planes, which is dragged.
    /// @param picture, planes  side by side
    /// Returns true if it takes the mouse.
    bool divide(WindowState& desk, const Area& picture, const Area& planes);

  private:
    /// The scan whose planes are drawn, and what only those of the first have.
    struct Scan;
    using Views = std::array<Area, 3>;
    static Views viewsOf(const WindowState& desk, const Area& area);
    static SliceWish sized(SliceWish wish, const Views& views);
    void drawScan(WindowState& desk, const Scan& scan, const Views& views);
    void drawPlane(WindowState& desk, const Scan& scan, const Area& view, std::size_t plane);
    void hand(WindowState& desk, const Scan& scan, const Area& view, int plane, const SliceFrame& frame);
    void upload(const Viewing& viewing);

    std::array<unsigned, 3> textures_{};
    std::shared_ptr<const ShownSlices> shown_;
    const VolumeSeen* askedOf_ = nullptr; // the other scan, and the planes it was asked for
    SliceWish asked_;
    int held_ = -1;        // plane under a button that is down
    bool windows_ = false; // it changes the window, not the crosshair
    bool divides_ = false;
};

} // namespace tessera

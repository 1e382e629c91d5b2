// viewer/window/panels.h: the left panel: the open volume, its view, light and colours, and their cost.
#pragma once

#include "viewer/window/cut_handles.h"
#include "viewer/window/endoscopy.h"
#include "viewer/window/function_editor.h"
#include "viewer/window/tools.h"
#include "viewer/window/window_state.h"

#include <cstdint>
#include <string>

namespace tessera {

class Panels {
  public:
    static constexpr float kWidth = 330; // in the screen's units

    /// Draws them where desk.showPanels says so.
    /// @param height  of the window
    void draw(WindowState& desk, Tools& tools, CutHandles& cuts, Endoscopy& endoscopy, float height);

  private:
    void files(WindowState& desk);
    void saving(WindowState& desk);
    void view(WindowState& desk);
    void planes(WindowState& desk);
    void undoPanel(WindowState& desk);
    void light(WindowState& desk);
    void state(WindowState& desk);

    FunctionEditor function_;
    char path_[1024] = {}, name_[1024] = {};
    int times_ = 1; // the picture's pixels that are saved, of those shown along a side
    std::string look_;
    std::uint64_t lookOf_ = 0; // the wish that look_ is of
};

/// What keys and mouse do.
void drawHelp(WindowState& desk);

} // namespace tessera

// viewer/window/panels.h: the left panel: the open volume, view, light, colours, and performance.
#pragma once

#include "viewer/window/cut_handles.h"
#include "viewer/window/endoscopy.h"
#include "viewer/window/function_editor.h"
#include "viewer/window/label_panel.h"
#include "viewer/window/mesh_panel.h"
#include "viewer/window/tools.h"
#include "viewer/window/window_state.h"

#include <cstdint>
#include <string>

namespace tessera {

// The mode part of the panel: the mode of rays, isosurfaces, the window of single values, and the position of
// a slice.

void modePanel(WindowState& desk);
void surfacesPanel(WindowState& desk);

class Panels {
  public:
    static constexpr float kWidth = 330; // in the screen's units

    /// Draws them if desk.showPanels is set.
    /// @param height  of the window
    void draw(WindowState& desk, Tools& tools, CutHandles& cuts, Endoscopy& endoscopy, float height);

  private:
    void files(WindowState& desk);
    void phases(WindowState& desk);
    void saving(WindowState& desk);
    void view(WindowState& desk);
    void planes(WindowState& desk);
    void undoPanel(WindowState& desk);
    void light(WindowState& desk);
    void state(WindowState& desk);

    FunctionEditor function_;
    LabelPanel labels_;
    MeshPanel meshes_;
    char path_[1024] = {}, name_[1024] = {};
    int phase_ = 0; // under the slider, while it is dragged
    int times_ = 1; // size of saved pictures, as a factor on the shown size
    std::string look_;
    std::uint64_t lookOf_ = 0; // the request of look_
    Lighting paths_;           // that were switched off last
};

/// The list of keys and mouse actions.
void drawHelp(WindowState& desk);

} // namespace tessera

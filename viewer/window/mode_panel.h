// viewer/window/mode_panel.h: the mode part of the panel: the mode of rays, isosurfaces, the window of single
// values, and the position of a slice.
#pragma once

#include "viewer/window/window_state.h"

namespace tessera {

void modePanel(WindowState& desk);
void surfacesPanel(WindowState& desk);

} // namespace tessera

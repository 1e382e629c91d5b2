// viewer/window/mode_panel.h: the mode part of the panel: the mode of rays, isosurfaces, the window of single
// values, and the position of a slice.
#pragma once

#include "viewer/window/desk.h"

namespace tessera {

void modePanel(Desk& desk);
void surfacesPanel(Desk& desk);

} // namespace tessera

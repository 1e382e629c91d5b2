// viewer/window/mode_panel.h: the part of the panel that says what is made of the values along a ray: the
// mode, and what belongs to it: isosurfaces, the window of single values, the place of a slice.
#pragma once

#include "viewer/window/desk.h"

namespace tessera {

void modePanel(Desk& desk);
void surfacesPanel(Desk& desk);

} // namespace tessera

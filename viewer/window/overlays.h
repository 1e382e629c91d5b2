// viewer/window/overlays.h: overlays on the pictures: what a figure says, the value under the pointer, and
// the quality of a picture.
#pragma once

#include "viewer/window/picture_view.h"
#include "viewer/window/window_state.h"

#include <string>

namespace tessera {

/// Drawn in the current frame, over the picture.
void drawOverlays(WindowState& desk, const Area& area, const PictureHand& hand);

/// Over that of the other scan: a line at its left edge, its name and how both are linked, what a figure
/// says, and the value under the pointer. The place under the pointer is marked in both.
void drawBeside(const Beside& beside, const WindowState& desk, const Area& area, const PictureHand& hand);

/// The samples and the noise of a picture of paths of light; empty for others.
std::string samplesText(const ShownPicture& picture);

} // namespace tessera

// viewer/window/overlays.h: overlays on the picture: what a figure says, the value under the pointer, and the
// picture's quality.
#pragma once

#include "viewer/window/picture_view.h"
#include "viewer/window/window_state.h"

#include <string>

namespace tessera {

/// Drawn in the current frame, over the picture.
void drawOverlays(WindowState& desk, const Area& area, const PictureHand& hand);

/// The samples and the noise of a picture of paths of light; empty for others.
std::string samplesText(const ShownPicture& picture);

} // namespace tessera

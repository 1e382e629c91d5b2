// viewer/window/overlays.h: overlays on the picture: the patient's directions, the scale, the value under the
// pointer, and the picture's quality.
#pragma once

#include "core/scene/measurement.h"
#include "viewer/window/picture_view.h"
#include "viewer/window/window_state.h"

#include <string>

struct ImDrawList;

namespace tessera {

/// Drawn in the current frame, over the picture.
void drawOverlays(WindowState& desk, const Area& area, const PictureHand& hand);

/// The samples and the noise of a picture of paths of light; empty for others.
std::string samplesText(const ShownPicture& picture);

/// At the lower edge of a picture.
/// @param right  its right end, units of the window
void drawScaleBar(ImDrawList& draw, const Area& area, const ScaleBar& bar, double right);

/// At the lower left of a picture, above the value under the pointer: a bar of colours for every volume.
void drawLegend(ImDrawList& draw, const Area& area, const std::vector<LegendBar>& bars);

} // namespace tessera

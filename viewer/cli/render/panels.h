// viewer/cli/render/panels.h: the panels of a figure of several pictures: what each shows, and one scale for
// all. Where they lie is in viewer/annotations/panel_sheet.h.
#pragma once

#include "core/scene/camera.h"

#include <string>
#include <vector>

namespace tessera {

/// In messages about figures of panels.
constexpr const char* kPanelOption = "--panel";

/// A panel: the picture of the arguments, but for these.
struct Panel {
    std::string view = {};              // of --view; "": that of the arguments
    std::string scene = {};             // a scene file or a volume in place of the arguments'; "": theirs
    std::vector<std::string> sets = {}; // KEY=VALUE, as of --set
};

/// The panels of --panel: sides between commas, TURN,RISE, a scene's file or a volume, or KEY=VALUE with
/// several of them between semicolons. Throws InputError naming --panel.
std::vector<Panel> panelsOf(const std::vector<std::string>& texts);

/// One scale for all parallel cameras, the largest mm a pixel, and one for all perspective ones, the largest
/// distance of the eye.
void shareScale(std::vector<Camera>& cameras);

} // namespace tessera

// viewer/cli/render/panels.h: figures of several pictures, `tessera render --panel`: which panels there are,
// one scale for all, and one file of them.
#pragma once

#include "viewer/cli/options/options.h"
#include "viewer/cli/render/render_task.h"
#include "viewer/cli/render/scene_from_arguments.h"

#include <functional>
#include <string>
#include <vector>

namespace tessera {

/// A panel: the picture of the arguments, but for these.
struct Panel {
    std::string view = {};              // of --view; "": that of the arguments
    std::string scene = {};             // a scene file or a volume in place of the arguments'; "": theirs
    std::vector<std::string> sets = {}; // KEY=VALUE, as of --set
};

/// The panels of --panel: sides between commas, TURN,RISE, a scene's file or a volume, or KEY=VALUE with
/// several of them between semicolons. Throws InputError naming --panel.
std::vector<Panel> panelsOf(const std::vector<std::string>& texts);

/// Where panels of one size lie: row by row from the upper left.
struct PanelGrid {
    int panels = 0, columns = 1, gap = 0; // pixels between neighbours
    glm::ivec2 panelSize{0};

    int rows() const { return (panels + columns - 1) / columns; }
    glm::ivec2 size() const;
    /// Upper left corner of a panel.
    glm::ivec2 at(int panel) const;
};
/// @param columns  0: as many as make the grid about square; three at most stand in a row
PanelGrid gridOf(int panels, int columns, int gap, const glm::ivec2& panelSize);

/// One scale for all cameras: of parallel ones the largest mm a pixel, of perspective ones the largest
/// distance of the eye. Cameras of the other projection than the first stay.
void shareScale(std::vector<Camera>& cameras);

/// Prepares the picture of arguments, and hands it over to be drawn.
using WithTask = std::function<void(const RenderArguments& arguments, const CommonOptions& common,
                                    const std::function<void(const RenderTask&)>& draw)>;

/// Draws all panels, one after the other within the budgets of one picture, and writes their figure. Throws
/// InputError naming an option that figures of panels cannot have.
void renderPanels(const RenderArguments& arguments, const CommonOptions& common, const WithTask& withTask);

} // namespace tessera

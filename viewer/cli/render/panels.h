// viewer/cli/render/panels.h: the panels of a figure of several pictures: what each shows, where it lies, and
// one scale for all.
#pragma once

#include "core/scene/camera.h"

#include <cstddef>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

namespace tessera {

/// A panel: the picture of the arguments, but for these.
struct Panel {
    std::string view = {};              // of --view; "": that of the arguments
    std::string scene = {};             // a scene file or a volume in place of the arguments'; "": theirs
    std::vector<std::string> sets = {}; // KEY=VALUE, as of --set
};

/// Of a figure.
constexpr std::size_t kMostPanels = 400;

/// The panels of --panel: sides between commas, TURN,RISE, a scene's file or a volume, or KEY=VALUE with
/// several of them between semicolons. Throws InputError naming --panel.
std::vector<Panel> panelsOf(const std::vector<std::string>& texts);

/// Where panels of one size lie: row by row from the upper left.
struct PanelGrid {
    int panels = 0, columns = 1, gap = 0; // pixels between neighbours
    glm::ivec2 panelSize{0};
    int above = 0, below = 0; // pixels of the title's and the caption's strips, of all panels

    int rows() const { return (panels + columns - 1) / columns; }
    glm::ivec2 size() const;
    /// Upper left corner of a panel.
    glm::ivec2 at(int panel) const;
};
/// @param columns  0: up to three stand in a row, more in a grid that is about square. Throws InputError
///     naming --panel for a figure with longer sides than pictures have
PanelGrid gridOf(int panels, int columns, int gap, const glm::ivec2& panelSize);

/// Throws InputError naming --panel for a figure, with its strips of words, of longer sides than pictures
/// have.
void checkSize(const PanelGrid& grid);

/// One scale for all cameras: of parallel ones the largest mm a pixel, of perspective ones the largest
/// distance of the eye. Cameras of the other projection than the first stay.
void shareScale(std::vector<Camera>& cameras);

} // namespace tessera

// viewer/cli/render/panel_figure.h: figures of several pictures, `tessera render --panel`: draws the panels,
// and writes one file of them.
#pragma once

#include "viewer/cli/options/options.h"
#include "viewer/cli/render/panels.h"
#include "viewer/cli/render/render_task.h"
#include "viewer/cli/render/scene_from_arguments.h"

#include <cstddef>
#include <functional>
#include <glm/vec2.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// Prepares the picture of arguments, and hands it over to be drawn.
using WithTask = std::function<void(const RenderArguments& arguments, const CommonOptions& common,
                                    const std::function<void(const RenderTask&)>& draw)>;

/// A panel whose camera and words are known.
struct FittedPanel {
    RenderArguments arguments;
    std::optional<Camera> camera; // none: as its scene has it
    Annotations annotations;
    std::string mark = {}; // its letter
};

struct PanelFigure {
    std::vector<FittedPanel> panels;
    PanelGrid grid;
    Annotations words; // the title and the caption of all panels, and their size
    bool oneScale = true;
    bool letters = false; // A, B, C in the corners of panels
};
/// Sets the cameras of panels as their scenes have them, in one scale where that is asked for, and their
/// annotations. Throws InputError for panels of several sizes.
/// @return the size of each
glm::ivec2 fitPanels(PanelFigure& figure, const CommonOptions& common, const WithTask& withTask);
/// Sets the strips above and below the panels by the shared words. Throws InputError as checkSize() does.
void makeRoomForWords(PanelFigure& figure);
/// RAM that the figure takes while its panels are drawn.
std::size_t bytesOf(const PanelGrid& grid);

/// Fits and draws the panels of arguments, one after the other within the budgets of one picture, and writes
/// their figure. Throws InputError naming an option that figures of panels cannot have.
void renderPanels(const RenderArguments& arguments, const CommonOptions& common, const WithTask& withTask);

/// Draws panels that are fitted.
/// @param arguments  its output, and whether the manifest is printed; that of a panel has its budgets
/// @param ram  charged with bytesOf() by the caller
void drawPanels(const PanelFigure& figure, const RenderArguments& arguments, const CommonOptions& common,
                MemoryBudget& ram, const WithTask& withTask);

/// The manifest's "figure", and the figure of one, without its panels. Throws InputError naming where.
nlohmann::json figureJson(const PanelFigure& figure);
PanelFigure figureOfJson(const nlohmann::json& said, int panels, const std::string& where);

} // namespace tessera

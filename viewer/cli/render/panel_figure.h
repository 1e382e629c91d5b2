// viewer/cli/render/panel_figure.h: figures of several pictures, `tessera render --panel`: draws the panels,
// and writes one file of them.
#pragma once

#include "core/base/budget.h"
#include "core/scene/annotations.h"
#include "core/scene/camera.h"
#include "viewer/annotations/panel_sheet.h"
#include "viewer/cli/options/options.h"
#include "viewer/cli/render/panels.h" // kPanelOption
#include "viewer/cli/render/render_task.h"
#include "viewer/cli/render/scene_from_arguments.h"

#include <functional>
#include <glm/vec2.hpp>
#include <optional>
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
};

struct PanelFigure {
    std::vector<FittedPanel> panels;
    PanelLayout layout;
};
/// Sets the cameras of panels as their scenes have them, in one scale where that is asked for, and their
/// annotations. Throws InputError for panels of several sizes.
/// @return the size of each
glm::ivec2 fitPanels(PanelFigure& figure, const CommonOptions& common, const WithTask& withTask);

/// Strips around the panels, as wide as any of them needs. After takeShared().
void fitStrips(PanelFigure& figure, const CommonOptions& common, const WithTask& withTask);

/// Fits and draws the panels of arguments, one after the other within the budgets of one picture, and writes
/// their figure. Throws InputError naming an option that figures of panels cannot have.
void renderPanels(const RenderArguments& arguments, const CommonOptions& common, const WithTask& withTask);

/// Draws panels that are fitted.
/// @param arguments  its output, and whether the manifest is printed; that of a panel has its budgets
/// @param ram  charged with bytesOf() the grid by the caller
void drawPanels(const PanelFigure& figure, const RenderArguments& arguments, const CommonOptions& common,
                MemoryBudget& ram, const WithTask& withTask);

} // namespace tessera

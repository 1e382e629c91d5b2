// viewer/cli/render/panel_figure.h: figures of several pictures, `tessera render --panel`: draws the panels,
// and writes one file of them.
#pragma once

#include "viewer/cli/options/options.h"
#include "viewer/cli/render/render_task.h"
#include "viewer/cli/render/scene_from_arguments.h"

#include <functional>

namespace tessera {

/// Prepares the picture of arguments, and hands it over to be drawn.
using WithTask = std::function<void(const RenderArguments& arguments, const CommonOptions& common,
                                    const std::function<void(const RenderTask&)>& draw)>;

/// Draws all panels, one after the other within the budgets of one picture, and writes their figure. Throws
/// InputError naming an option that figures of panels cannot have.
void renderPanels(const RenderArguments& arguments, const CommonOptions& common, const WithTask& withTask);

} // namespace tessera

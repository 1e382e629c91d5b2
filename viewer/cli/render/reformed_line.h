// viewer/cli/render/reformed_line.h: `tessera render --path --straighten` and `--curved`: one picture of the
// values along a path's line (docs/reformations.md).
#pragma once

#include "viewer/cli/render/render_task.h"

namespace tessera {

/// Throws InputError naming an option of reformations without one, and one that has no effect with one.
void checkReformation(const RenderArguments& arguments);

/// Draws and writes it, and says how much of it the folds of rows take. Throws as pathOf(), renderReformed()
/// and writeImage() do, and InputError naming a path without lines.
void renderReformedLine(const RenderTask& task);

} // namespace tessera

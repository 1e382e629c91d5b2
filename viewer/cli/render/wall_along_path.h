// viewer/cli/render/wall_along_path.h: `tessera render --path --unfold`: one picture of the wall around a
// path's line, cut open.
#pragma once

#include "viewer/cli/render/render_task.h"

namespace tessera {

/// Draws and writes it. Throws as pathOf(), renderUnfolded() and writeImage() do, and InputError naming a
/// path without lines.
void renderWall(const RenderTask& task);

} // namespace tessera

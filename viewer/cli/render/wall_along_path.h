// viewer/cli/render/wall_along_path.h: `tessera render --path --unfold`: one picture of the wall around
// a path's line, slit open.
#pragma once

#include "viewer/cli/render/render_task.h"

namespace tessera {

/// Draws and writes it. Throws what pathOf(), renderUnfolded() and writeImage() throw, and InputError naming
/// a path without lines.
void renderWall(const RenderTask& task);

} // namespace tessera

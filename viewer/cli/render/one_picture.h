// viewer/cli/render/one_picture.h: `tessera render` without --path: one converged picture
// and its manifest.
#pragma once

#include "viewer/cli/render/render_task.h"

namespace tessera {

/// Draws and writes it. Throws as renderScene() and writeImage() do, and InputError for --first with an
/// engine that draws none.
void renderOnePicture(const RenderTask& task);

} // namespace tessera

// viewer/cli/render/film_of_path.h: `tessera render --path`: a film, into a folder of frames or a file.
#pragma once

#include "viewer/cli/render/render_task.h"

namespace tessera {

/// Draws missing frames, and reports them. Throws as pathOf(), parseFrames() and drawFilm() do.
void renderFilm(const RenderTask& task);

} // namespace tessera

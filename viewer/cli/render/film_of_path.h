// viewer/cli/render/film_of_path.h: `tessera render --path`: a film, into a folder of frames or a file.
#pragma once

#include "viewer/cli/render/render_task.h"

namespace tessera {

/// Draws what is not there yet, and tells it. Throws what pathOf(), parseFrames() and drawFilm() throw.
void renderFilm(const RenderTask& task);

} // namespace tessera

// viewer/cli/render/tiled_picture.h: `tessera render --tiles`: one picture that is drawn tile by tile, by any
// number of processes with the same command.
#pragma once

#include "viewer/cli/render/render_task.h"

#include <glm/vec2.hpp>

namespace tessera {

/// The pixels that are drawn together: those of the largest tile, or of the picture.
glm::ivec2 pixelsTogether(const RenderArguments& arguments, const Scene& scene);

/// Throws InputError naming an option that --tiles cannot be combined with, and what of a scene needs all
/// pixels of its picture at once.
void checkTiles(const RenderArguments& arguments, const Scene& scene);

/// Draws the tiles that are missing. One of the processes writes the picture and its manifest, once all are
/// there. Throws InputError for a folder with tiles of another picture or plan, and as renderScene() and
/// writeRows() do.
void renderTiledPicture(const RenderTask& task);

} // namespace tessera

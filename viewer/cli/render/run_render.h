// viewer/cli/render/run_render.h: `tessera render`: checks options first, opens the store, and draws a
// picture, a film or an unfolded wall.
#pragma once

#include "viewer/cli/options/options.h"
#include "viewer/cli/render/scene_from_arguments.h"

namespace tessera {

/// Throws InputError naming an option or a file, and as drawing does.
void runRender(const RenderArguments& arguments, const CommonOptions& common);

} // namespace tessera

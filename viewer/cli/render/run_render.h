// viewer/cli/render/run_render.h: `tessera render`: checks options first, opens the store, and draws a
// picture, a film or an unfolded wall.
#pragma once

#include "viewer/cli/options/options.h"
#include "viewer/cli/render/render_task.h"
#include "viewer/cli/render/scene_from_arguments.h"

#include <functional>

namespace tessera {

/// Throws InputError naming an option or a file, and as drawing does.
void runRender(const RenderArguments& arguments, const CommonOptions& common);

/// The same of one picture, which is taken in place of its file.
/// @param scene  in place of the one that the arguments name; null: that one
void runRender(const RenderArguments& arguments, const CommonOptions& common, const Scene* scene,
               const TakePicture& take);

/// Prepares a picture of arguments as runRender() does, and hands it over to be drawn.
void withRenderTask(const RenderArguments& arguments, const CommonOptions& common,
                    const std::function<void(const RenderTask&)>& draw);

} // namespace tessera

// viewer/cli/render/path_of_arguments.h: the path of a film or of an unfolded wall, and the options that
// only they have.
#pragma once

#include "core/animation/path.h"
#include "viewer/cli/render/render_task.h"

namespace tessera {

/// Throws InputError naming an option of films without --path or --turn, and one that --path or --unfold has
/// no use for.
void checkFilmOptions(const RenderArguments& arguments);

/// The path as the options have it; a line alone is flown. Notes where it was made in another volume.
/// Throws InputError naming the file that is no path, and --speed and --seconds where nothing is flown.
Path pathOf(const RenderTask& task);

/// Of --turn: a turntable that holds what the scene shows, from the scene's side, or around what its camera
/// looks at. Throws InputError naming --turn for a slice, and --frames for what is no count.
Path turnOf(const RenderTask& task);

} // namespace tessera

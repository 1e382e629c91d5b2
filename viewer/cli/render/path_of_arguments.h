// viewer/cli/render/path_of_arguments.h: the path of a film or of an unfolded wall, and the options for these
// alone.
#pragma once

#include "core/animation/path.h"
#include "viewer/cli/render/render_task.h"

namespace tessera {

/// Throws InputError naming an option of films without --path or --turn, and one that has no effect with
/// --path or --unfold.
void checkFilmOptions(const RenderArguments& arguments);

/// The path with the options applied; a path with lines alone gets a flight. Notes if it was made in another
/// volume. Throws InputError naming a file that is no path, and --speed and --seconds without a flight.
Path pathOf(const RenderTask& task);

/// For --turn: a turntable fitted to what the scene shows, from the scene's side, or around its camera's
/// focal point. Throws InputError naming --turn for a slice, and --frames for an invalid count.
Path turnOf(const RenderTask& task);

} // namespace tessera

// viewer/cli/render/along_path.h: `tessera render --path`: what follows a path, a film or an unfolded wall.
#pragma once

#include "core/animation/path.h"
#include "viewer/cli/render/render_task.h"

#include <nlohmann/json_fwd.hpp>

namespace tessera {

// The path of a film or of an unfolded wall, and the options for these alone.

/// Throws InputError naming an option of films without --path or --turn, and one that has no effect with
/// --path or --unfold.
void checkFilmOptions(const RenderArguments& arguments);

/// As it is given, or that of the file. Throws as loadPath() does.
Path readPathOf(const RenderArguments& arguments);
/// The path with the options applied; a path with lines alone gets a flight. Notes if it was made in another
/// volume. Throws InputError naming a file that is no path, and --speed and --seconds without a flight.
Path pathOf(const RenderTask& task);

/// For --turn: a turntable fitted to what the scene shows, from the scene's side, or around its camera's
/// focal point. Throws InputError naming --turn for a slice, and --frames for an invalid count.
Path turnOf(const RenderTask& task);

/// Draws missing frames, and reports them. Throws as pathOf(), parseFrames() and drawFilm() do.
void renderFilm(const RenderTask& task);

/// What a manifest of a picture along a line has of it, beside its other keys: `path`, what redraws it
/// (viewer/cli/redraw/), where that is small enough.
void tellPath(nlohmann::json& manifest, const Path& path);

// `tessera render --path --unfold`: one picture of the wall around a path's line, cut open.

/// Draws and writes it. Throws as pathOf(), renderUnfolded() and writeImage() do, and InputError naming a
/// path without lines.
void renderWall(const RenderTask& task);

} // namespace tessera

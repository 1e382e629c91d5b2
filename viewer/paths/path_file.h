// viewer/paths/path_file.h: paths from files: our own (core/animation/path.h), and lines of points that other
// programs or people made.
#pragma once

#include "core/animation/path.h"

#include <filesystem>
#include <string>

namespace tessera {

/// What a file of any of these forms has:
/// - a path, as loadPath() reads it;
/// - markups of 3D Slicer (.mrk.json): each of its curves, lines and point lists becomes a line
///   (viewer/paths/markups.h);
/// - a table of points (.csv, .tsv, .txt): one line (viewer/paths/point_table.h).
/// The last two have neither volume nor lumen, and radii only where the table has them.
/// Throws InputError naming the file and the place in it, what was expected and what was found.
Path loadPathFile(const std::filesystem::path& file);

} // namespace tessera

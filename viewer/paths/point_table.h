// viewer/paths/point_table.h: a line of points in a table.
#pragma once

#include "core/animation/path.h"

#include <filesystem>

namespace tessera {

/// By its name: .csv, .tsv, .txt.
bool isPointTable(const std::filesystem::path& file);

/// Rows are points in their order along the line, mm. Columns are x,y,z or l,p,s (LPS), or r,a,s, as 3D
/// Slicer exports them; radius, if it is there, is the distance to the wall. Rows whose column `defined` is 0
/// have no place. Other columns count for nothing. Names are taken in any case.
/// Throws InputError naming the file and the line: as CsvTable does, for other columns, for what is no
/// number, and as lineThrough() does.
Path pathOfTable(const std::filesystem::path& file);

} // namespace tessera

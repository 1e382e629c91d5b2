// viewer/paths/markups.h: lines of 3D Slicer's markups (.mrk.json), by its markups schema, versions 1.0.
#pragma once

#include "core/animation/path.h"

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

/// A document with a list of markups.
bool isMarkups(const nlohmann::json& document);

/// Each curve, closed curve, line and point list with two or more points becomes a line, in the file's order;
/// the first is flown. Points without a place are left out. Coordinates are LPS or RAS, as the file says, LPS
/// where it says nothing.
/// Throws InputError naming the file and the place in it: for no such markup, another unit than mm, another
/// coordinate system, and as lineThrough() does.
Path pathOfMarkups(const nlohmann::json& document, const std::string& where);

} // namespace tessera

// core/animation/path_text.h: texts about centre-lines, for programs and windows alike.
#pragma once

#include "core/animation/path.h"

#include <string>
#include <vector>

namespace tessera {

/// How long lines are together, and how near to the wall: of places that are not on bridges.
struct LinesExtent {
    double lengthMm = 0, narrowestMm = 0, widestMm = 0;
};
LinesExtent extentOf(const std::vector<CentreLine>& lines);

/// "a line of 120.4 mm, 3.1 to 8 mm from the wall", "21 branches of ...".
std::string linesText(const std::vector<CentreLine>& lines);

/// Why lines of a lumen may lie outside of it, and from where on; empty where nothing speaks for that.
std::string doubtText(const Lumen& lumen);

} // namespace tessera

// core/animation/path_text.h: texts about centre-lines, for commands and windows.
#pragma once

#include "core/animation/path.h"

#include <string>
#include <vector>

namespace tessera {

/// Total length of lines, and their least and largest distance to the wall, bridges apart.
struct LinesExtent {
    double lengthMm = 0, narrowestMm = 0, widestMm = 0;
};
LinesExtent extentOf(const std::vector<CentreLine>& lines);

/// "a line of 120.4 mm, 3.1 to 8 mm from the wall", "21 branches of ...".
std::string linesText(const std::vector<CentreLine>& lines);

/// The reason why lines of a lumen may lie outside of it, and from where on. Empty if there is none.
std::string doubtText(const Lumen& lumen);

} // namespace tessera

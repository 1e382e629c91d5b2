// core/animation/path_text.cpp: see path_text.h.
#include "core/animation/path_text.h"

#include "core/base/shown_text.h"

#include <algorithm>

namespace tessera {

LinesExtent extentOf(const std::vector<CentreLine>& lines) {
    LinesExtent extent;
    for (const CentreLine& line : lines) {
        extent.lengthMm += line.lengthMm();
        for (const double radius : line.radiusMm) {
            if (radius > 0 && (extent.narrowestMm == 0 || radius < extent.narrowestMm))
                extent.narrowestMm = radius;
            extent.widestMm = std::max(extent.widestMm, radius);
        }
    }
    return extent;
}

std::string linesText(const std::vector<CentreLine>& lines) {
    const LinesExtent extent = extentOf(lines);
    return (lines.size() == 1 ? "a line" : std::to_string(lines.size()) + " branches") + " of " +
           mmText(extent.lengthMm) + ", " + mmText(extent.narrowestMm) + " to " + mmText(extent.widestMm) +
           " from the wall";
}

std::string doubtText(const Lumen& lumen) {
    if (lumen.leaks)
        return "this line may have left the lumen" +
               (lumen.leavesAtMm ? " at " + mmText(*lumen.leavesAtMm) : "") + ": it leaks at its threshold";
    if (lumen.unsure)
        return "this line may lie outside of the lumen: its threshold hardly differs from the noise in it";
    return {};
}

} // namespace tessera

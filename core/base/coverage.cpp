// core/base/coverage.cpp: see coverage.h.
#include "core/base/coverage.h"

#include <cstdio>
#include <string>

namespace tessera {

std::string coverageText(const WallCoverage& coverage, double smallestMm2) {
    char words[240];
    std::snprintf(words, sizeof words,
                  "seen: %.1f %% of %.1f cm2 of wall; unseen patches of at least %g mm2: %zu",
                  100 * coverage.share(), 0.01 * coverage.wallMm2, smallestMm2, coverage.patches.size());
    std::string text = words;
    if (!coverage.patches.empty()) {
        std::snprintf(words, sizeof words, "; the largest, %.0f mm2, at %.0f mm", coverage.patches[0].areaMm2,
                      coverage.patches[0].alongMm);
        text += words;
    }
    if (coverage.flown < coverage.lines)
        text += "; along " + std::to_string(coverage.flown) + " of " + std::to_string(coverage.lines) +
                " lines, the wall of the others does not count: the path's flight.route names those that are "
                "flown";
    return text;
}

} // namespace tessera

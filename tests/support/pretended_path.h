// tests/support/pretended_path.h: a line through a hollow organ, and a Viewing that has found it.
#pragma once

#include "tests/support/pretended_viewing.h"

#include <memory>

namespace tessera::test {

/// A line upwards and a branch of it to the left.
inline std::shared_ptr<Path> pretendedPath(bool leaks) {
    auto path = std::make_shared<Path>();
    CentreLine stem{"stem", {}, {}, 10, {}, 0}, branch{"branch", {}, {}, 10, 0, 40};
    for (int n = 0; n < 9; ++n) {
        stem.points.push_back({-5, -5, -50 + 10 * n});
        stem.radiusMm.push_back(6 - 0.4 * n);
    }
    for (int n = 0; n < 4; ++n) {
        branch.points.push_back({-5 + 6 * n, -5, -10 + 8 * n});
        branch.radiusMm.push_back(3);
    }
    path->lines = {stem, branch};
    path->lumen.emplace();
    path->lumen->threshold = -500;
    path->lumen->leaks = leaks;
    if (leaks)
        path->lumen->leavesAtMm = 30;
    return path;
}

inline void foundLine(PretendedViewing& viewing, bool leaks) {
    viewing.lineNow = {};
    viewing.lineNow.number = viewing.lines;
    viewing.lineNow.about = "2 lines of 110 mm; 3 to 6 mm from the wall";
    viewing.lineNow.path = pretendedPath(leaks);
}

inline void foundCoverage(PretendedViewing& viewing) {
    auto coverage = std::make_shared<WallCoverage>();
    for (int n = 0; n < 14; ++n)
        coverage->patches.push_back(
            {{-5 + n, -9, -30 + 5 * n}, 100.0 - 5 * n, 20.0 + 4 * n, 15.0 + 4 * n, 26.0 + 4 * n});
    viewing.lineNow = {};
    viewing.lineNow.number = viewing.lines;
    viewing.lineNow.about = "80 % of the wall are seen";
    viewing.lineNow.coverage = coverage;
}

} // namespace tessera::test

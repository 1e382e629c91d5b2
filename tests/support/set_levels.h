// tests/support/set_levels.h: plans with levels of the test's own.
#pragma once

#include "render/plan/planner.h"

namespace tessera::test {

/// All bricks that show something are of one level.
inline void setLevels(Planner& p, int level) {
    Selection levels = p.layer().selection;
    levels.counts = {};
    for (std::uint8_t& mine : levels.levels) {
        mine = mine == Selection::kEmpty ? mine : static_cast<std::uint8_t>(level);
        ++levels.counts[mine];
    }
    p.setSelection(levels);
}

} // namespace tessera::test

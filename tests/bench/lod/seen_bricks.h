// tests/bench/lod/seen_bricks.h: how much of each brick a picture shows, with what lies before it: the
// visibility that a choice of levels can use (bricking/levels/level_selection.h), computed slowly from the
// finest data.
#pragma once

#include "render/plan/scene_plan.h"

#include <vector>

namespace tessera::bench {

/// Per brick, [z][y][x]: the mean, over the rays that cross it, of what light passes all that lies before it;
/// 1 for bricks that no ray crosses. In [0,1].
/// @param culled  every brick that shows something at level 0
/// @param pixels  rays an axis
std::vector<float> seenBricks(const ScenePlan& scene, const Selection& culled, int pixels);

} // namespace tessera::bench

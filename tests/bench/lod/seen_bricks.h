// tests/bench/lod/seen_bricks.h: the visibility of each brick in a picture, with what lies before it. A
// choice of levels can use it (bricking/levels/level_selection.h). It is computed slowly from the finest
// data.
#pragma once

#include "render/plan/frame_plan.h"

#include <vector>

namespace tessera::bench {

/// Per brick, [z][y][x]: the mean, over the rays that cross it, of what light passes all that lies before it;
/// 1 for bricks that no ray crosses. In [0,1].
/// @param culled  every brick that shows something at level 0
/// @param pixels  rays an axis
std::vector<float> seenBricks(const FramePlan& scene, const Selection& culled, int pixels);

} // namespace tessera::bench

// render/plan/overlooked_pixels.h: where rays through the middles of pixels can have missed what a volume
// shows: pixels that a cell lies in which can show something, and of which no pixel that it lies in shows
// anything. Single voxels that are smaller than a pixel, and what reaches into the picture by less than half
// a pixel, are found by nothing else.
#pragma once

#include "core/image.h"
#include "render/plan/scene_plan.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

/// Numbers of such pixels, row by row, in ascending order; none where the plan has no map of empty space.
/// Cells as large on the picture as what they hold is found anyway are passed over. Takes 8 bytes of RAM a
/// pixel, its answer included.
/// @param middles  what rays through the middles came to
std::vector<std::uint32_t> overlookedPixels(const ScenePlan& plan, const Image& middles);

} // namespace tessera

// render/plan/overlooked_pixels.h: pixels where rays through the middles can have missed something. A cell
// that can show something lies in such a pixel, and no pixel that the cell lies in shows anything. Nothing
// else finds single voxels that are smaller than a pixel, or a part that reaches into the picture by less
// than half a pixel.
#pragma once

#include "core/image/image.h"
#include "render/plan/frame_plan.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

/// Numbers of such pixels, row by row, in ascending order; none where the plan has no distance map. Cells as
/// large on the picture as what they hold is found anyway are passed over. Takes 8 bytes of RAM a pixel, its
/// answer included.
/// @param middles  what rays through the middles came to
std::vector<std::uint32_t> overlookedPixels(const FramePlan& plan, const Image& middles);

} // namespace tessera

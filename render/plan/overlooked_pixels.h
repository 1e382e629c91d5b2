// render/plan/overlooked_pixels.h: pixels in which rays through the centres may have missed something. Such a
// pixel contains an occupied cell none of whose pixels shows anything. Only this finds single voxels smaller
// than a pixel, and parts that extend into the picture by less than half a pixel.
#pragma once

#include "core/image/image.h"
#include "render/plan/frame_plan.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

/// Numbers of such pixels, row by row, in ascending order; none if the plan has no distance map. Cells that
/// are large on the picture are skipped, because their content is found anyway. Takes 8 bytes of RAM per
/// pixel, including the result.
/// @param middles  colours of rays through the centres
std::vector<std::uint32_t> overlookedPixels(const FramePlan& plan, const Image& middles);

} // namespace tessera

// viewer/session/picking.h: picks the visible point in the volume at a pixel of the picture.
#pragma once

#include "core/scene/camera.h"
#include "render/plan/drawn_part.h"
#include "render/plan/frame_plan.h"
#include "viewer/session/viewing.h"

#include <glm/vec2.hpp>

namespace tessera {

/// Searches the drawn part of the ray, within cuts. In modes of single values it is the point of that value,
/// for an average the middle of the ray. Otherwise it is the point that contributes most: where opacity rises
/// most over a voxel to either side, or the first isosurface of at least that opacity. The point is found at
/// a level that is read quickly, then refined at level 0, whatever levels are drawn. If level 0 cannot be
/// read, the coarse point remains, and is marked.
/// @param place  of the picture, pixels, x right, y down
/// Throws what decoding the coarse level threw.
PickedPlace pickPlace(const Layer& volume, const DrawnPart& part, const Camera& camera,
                      const glm::ivec2& imageSize, const glm::dvec2& place);

} // namespace tessera

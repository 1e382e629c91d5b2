// viewer/session/picking.h: picks the point in the volume that one sees at a pixel of the picture.
#pragma once

#include "core/scene/camera.h"
#include "render/plan/drawn_part.h"
#include "render/plan/layer.h"
#include "viewer/session/viewing.h"

#include <glm/vec2.hpp>

namespace tessera {

/// Along what is drawn of the ray (cuts leave the rest out). In modes that show single values it is the place
/// of that value. Else it is the place where the picture gets most of what it shows. There opacity rises
/// most, over a voxel to either side, or the first isosurface lies that is not fainter than that. It is found
/// at a level that is read quickly, then once more around that place at level 0, whatever levels are drawn.
/// Where level 0 cannot be read, it stays at the coarse place, and says so.
/// Of an average, the middle of the way.
/// @param place  of the picture, pixels, x right, y down
/// Throws what decoding the coarse level threw.
PickedPlace pickPlace(const Layer& volume, const DrawnPart& part, const Camera& camera,
                      const glm::ivec2& imageSize, const glm::dvec2& place);

} // namespace tessera

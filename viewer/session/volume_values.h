// viewer/session/volume_values.h: what a window asks of a volume besides pictures: points, values and their
// histogram.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "core/base/volume.h"
#include "core/scene/camera.h"
#include "core/scene/measurement.h"
#include "render/plan/drawn_part.h"
#include "render/plan/frame_plan.h"
#include "viewer/session/viewing.h"

#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

namespace tessera {

// Picks the visible point in the volume at a pixel of the picture.

/// A mesh's surface on a ray.
struct MeshOnRay {
    glm::dvec3 voxel{0};
    double opacity = 1;
    std::string mesh; // its name
};

/// Searches the drawn part of the ray, within cuts. On a slice without thickness it is the plane's point. In
/// modes of single values it is the point of that value, for an average the middle of the ray. Otherwise it
/// is the point that contributes most: where opacity rises most over a voxel to either side, or the first
/// isosurface of at least that opacity; of labels what their voxels show. The point is found at a level that
/// is read quickly, then refined at level 0, whatever levels are drawn. If level 0 cannot be read, the coarse
/// point remains, and is marked.
/// @param place  of the picture, pixels, x right, y down
/// @param meshes  the surfaces that the ray meets, in order: one is picked where it contributes more than any
///     point of the volume
/// Throws what decoding the coarse level threw.
PickedPlace pickPlace(const Layer& volume, const DrawnPart& part, const Camera& camera,
                      const glm::ivec2& imageSize, const glm::dvec2& place,
                      std::span<const MeshOnRay> meshes = {});

// The histogram of a volume, fine enough to edit a transfer function over it.

/// Counts over equal bins of [lowest, highest], physical units, of the values within, of all samples of the
/// finest level that has at most two million. Read through the cache.
/// @param bins  at least 1
/// Throws what decoding threw.
std::vector<double> volumeHistogram(const Layer& volume, double lowest, double highest, int bins);

} // namespace tessera

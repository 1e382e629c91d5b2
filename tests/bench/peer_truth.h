// tests/bench/peer_truth.h: the truth that renderers are compared with: the reference's picture, on fewer
// pixels. It leaves out the pixels in which two renderers may differ by definition.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "core/image/image.h"
#include "render/plan/frame_plan.h"

#include <glm/vec2.hpp>
#include <vector>

namespace tessera::bench {

Image roundedTo8Bits(Image image);

/// The pixels of thinned(), by the reference; shift moves the ray inside each pixel.
Image referenceImage(BrickCache& cache, const FramePlan& p, const Shading& shading, const glm::ivec2& size,
                     int stride, const glm::dvec2& shift);

/// For each of these pixels, whether its ray runs through the outermost half voxel of a side that it does not
/// enter by facing it. VTK's volume ends at voxel centres, ours at voxel faces: there the two differ by
/// definition.
std::vector<bool> borderPixels(const FramePlan& p, const glm::ivec2& size, int stride);

/// The picture, black and transparent where left out: such pixels are in no error.
Image without(Image image, const std::vector<bool>& leftOut);

} // namespace tessera::bench

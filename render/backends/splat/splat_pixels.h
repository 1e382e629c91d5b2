// render/backends/splat/splat_pixels.h: pixels of a picture of splats again, and what they should be: the
// true integral along rays, by the reference.
#pragma once

#include "core/image/image.h"
#include "render/renderer.h"

#include <memory>

namespace tessera {

/// All of it outlives the result.
/// @param picture  as it was drawn: a pixel drawn again has the same bits
std::unique_ptr<PixelSource> splatPixels(const FrameTask& task, const Image& picture, int threads);

} // namespace tessera

// render/picture/measure_picture.h: measures the error of a picture just drawn. Pixels are drawn again by
// the renderer that drew it, within the same budgets, as they are and as they should be.
#pragma once

#include "core/scene/scene.h"
#include "render/picture/pixels_again.h"

#include <cstdint>

namespace tessera {

struct DrawnPicture {
    const Scene& scene;
    DrawnPixels pixels;
    std::uint64_t bytes = 0;    // of bricks that it took
    double samplesPerPixel = 1; // in the mean
    Verify mode = Verify::quick;
    int round = 0, rounds = 1; // of measurements of this picture, and how many there may be
    Slicing slicing;
    bool light = false;  // the error of kept light is asked for
    PixelOver over = {}; // what lies over the pixels, and has been laid over the image
};

/// @param source  gives the picture's pixels, and then the truth
/// @param ram  pixels drawn again are charged here
/// A picture of 512 x 512 pixels and more pays a quarter of its bytes at most for Verify::quick. An error
/// that cannot be measured for that, or in these budgets, is reported as such and not guessed.
PictureMeasurement measurePicture(const DrawnPicture& picture, PixelSource& source, MemoryBudget& ram);

} // namespace tessera

// render/verify/picture_measurement.h: the error of a picture, measured by drawing some of its pixels again.
#pragma once

#include "render/verify/measured_errors.h"
#include "render/verify/verify_plan.h"

#include <cstddef>
#include <string>

namespace tessera {

/// The error of a picture against the mean over each pixel's area of the integral through the finest level.
struct PictureMeasurement {
    Verify mode = Verify::none;
    std::string whyNot; // the reason if nothing was measured; empty: `all` has the numbers
    MeasuredErrors all;
    /// The same pixels with the picture's own levels, step, filtering and early termination, but as many
    /// samples as the truth. They separate the error of the picture's pixel samples from all other causes.
    MeasuredErrors sampling, rays;
    /// The picture has light per voxel or surface: the error of that light is not in these numbers, because
    /// the truth has the same light.
    bool keptLight = false;
    bool singleRays = false;          // the picture has one ray per pixel
    int samples = 0, mostSamples = 0; // rays of a pixel's truth; rays with which it was too noisy
    std::size_t bytesRead = 0;
    double seconds = 0;
};

} // namespace tessera

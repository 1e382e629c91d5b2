// render/verify/picture_measurement.h: how wrong a picture is, measured by drawing some of its pixels again.
#pragma once

#include "render/verify/measured_errors.h"
#include "render/verify/verify_plan.h"

#include <cstddef>
#include <string>

namespace tessera {

/// How wrong a picture is against the mean over each pixel's area of the integral through the finest level.
struct PictureMeasurement {
    Verify mode = Verify::none;
    std::string whyNot; // nothing was measured; empty: it was, as far as `all` holds numbers
    MeasuredErrors all;
    /// The same pixels with the picture's own levels, step, filtering and ends of rays, but as many samples
    /// as the truth. They tell the error of the picture's samples of a pixel, and that of all other causes.
    MeasuredErrors sampling, rays;
    /// The picture has light that is kept of voxels or surfaces: what that light itself errs by is in none of
    /// these numbers, because the truth has the same.
    bool keptLight = false;
    bool singleRays = false;          // the picture has one ray a pixel
    int samples = 0, mostSamples = 0; // of the truth of a pixel; of those that it was too noisy with
    std::size_t bytesRead = 0;
    double seconds = 0;
};

} // namespace tessera

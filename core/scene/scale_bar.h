// core/scene/scale_bar.h: a scale bar: a round length for a picture, and the bar drawn into one. Windows draw
// their own.
#pragma once

#include "core/image/image.h"
#include "core/scene/camera.h"

#include <string>

namespace tessera {

/// The largest length of 1, 2 or 5 times a power of ten that is at most `mm`; 1 if `mm` is no length.
double roundLength(double mm);

struct ScaleBar {
    double mm = 1, pixels = 1;
    bool everywhere = true; ///< else only at the depth of the picture's centre: nearer objects are larger

    /// "50 mm", "50 mm at the centre".
    std::string text() const;
};

/// At most a quarter of the picture's width. Exact across the direction of view: everywhere in parallel
/// projection, else at the depth of the camera's focal point, which is the picture's centre.
ScaleBar scaleBarOf(const Camera& camera, const glm::ivec2& imageSize);
/// For a plane that the picture shows at one scale.
/// @param width  of the picture, pixels
ScaleBar scaleBarOf(double mmPerPixel, double width);

/// At the lower right, with its text above it: white with a black edge, visible on any picture. The outer
/// edges of its ends are bar.pixels apart, rounded to whole pixels.
void drawScaleBar(Image& image, const ScaleBar& bar);

} // namespace tessera

// core/scene/scale_bar.h: a scale bar: a round length for a picture, and the bar drawn into one. Windows draw
// it in their own way.
#pragma once

#include "core/image/image.h"
#include "core/scene/camera.h"

#include <string>

namespace tessera {

/// A length of 1, 2 or 5 times a power of ten that is at most `mm`, mm; 1 where that is no length.
double roundLength(double mm);

struct ScaleBar {
    double mm = 1, pixels = 1;
    bool everywhere = true; ///< else at the depth of the picture's centre alone: nearer things are larger

    /// "50 mm", "50 mm at the centre".
    std::string text() const;
};

/// At most a quarter as long as the picture is wide. Exact across the direction of view: everywhere in
/// parallel projection, else at the depth of the camera's focal point, which is the picture's centre.
ScaleBar scaleBarOf(const Camera& camera, const glm::ivec2& imageSize);
/// Of a plane that the picture shows at one scale.
/// @param width  of the picture, pixels
ScaleBar scaleBarOf(double mmPerPixel, double width);

/// At the lower right, with its text above it: white with a black edge, so that it shows on anything. The
/// outer edges of its ends are bar.pixels apart, rounded to whole pixels.
void drawScaleBar(Image& image, const ScaleBar& bar);

} // namespace tessera

// viewer/presets/curves.h: curves and colour maps as VTK interpolates them, as points between which ours are
// straight, and back.
#pragma once

#include "core/transfer_function.h"

#include <string>
#include <vector>

namespace tessera {

/// A point of vtkPiecewiseFunction.
struct VtkPoint {
    double x = 0, y = 0, midpoint = 0.5, sharpness = 0;
};
/// A point of vtkColorTransferFunction; the colour as screens show it (sRGB), [0,1].
struct VtkColour {
    double x = 0;
    glm::dvec3 colour{0};
    double midpoint = 0.5, sharpness = 0;
};
/// As ParaView's files name them; what vtkColorTransferFunction interpolates in.
enum class ColourSpace { rgb, hsv, lab, diverging, labCiede2000, step };

/// Points in any order; two at one place are a step. y is clamped to [0,1].
std::vector<OpacityPoint> opacityPoints(std::vector<VtkPoint> points);
std::vector<ColourPoint> colourPoints(std::vector<VtkColour> points, ColourSpace space, bool wrapsHue);

/// Straight between sRGB colours what is straight in linear light here.
std::vector<VtkColour> screenColours(const std::vector<ColourPoint>& points);
/// Points that no two of share a place, as VTK keeps them: steps become as steep as numbers allow.
std::vector<VtkPoint> distinct(const std::vector<OpacityPoint>& points);

} // namespace tessera

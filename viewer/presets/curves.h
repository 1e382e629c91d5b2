// viewer/presets/curves.h: curves and colour maps as VTK interpolates them, as points between which ours are
// straight, and back.
#pragma once

#include "core/scene/transfer_function.h"
#include "viewer/presets/foreign_preset.h" // kOpacityError

#include <cstddef>
#include <string>
#include <vector>

namespace tessera {

/// Of a curve in a file: VTK sorts all points at each that is added, and looks for a value from the first on.
constexpr std::size_t kMostCurvePoints = 2048;

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
/// @param mostError  of an opacity, where a curve is not straight
std::vector<OpacityPoint> opacityPoints(std::vector<VtkPoint> points, double mostError = kOpacityError);
/// Takes the points away that matter least, until there are as many as asked for, 2 at least. Returns the
/// largest error that one of them leaves.
double thinned(std::vector<OpacityPoint>& points, std::size_t most);
std::vector<ColourPoint> colourPoints(std::vector<VtkColour> points, ColourSpace space, bool wrapsHue);

/// Straight between sRGB colours what is straight in linear light here.
std::vector<VtkColour> screenColours(const std::vector<ColourPoint>& points);
/// Points that no two of share a place, as VTK keeps them: steps become as steep as numbers allow.
std::vector<VtkPoint> distinct(const std::vector<OpacityPoint>& points);

} // namespace tessera

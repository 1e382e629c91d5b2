// viewer/presets/preset_files.h: the readers of other programs' files, and what they share: VTK's curves as
// ours. Private to this room.
#pragma once

#include "core/scene/transfer_function.h"
#include "viewer/presets/foreign_preset.h" // kOpacityError

#include <cstddef>
#include <string>
#include <vector>

namespace tessera {

// Conversion of VTK's curves and colour maps to piecewise linear points, and back.

/// Largest number of points of a curve in a file: VTK sorts all points for each one added, and searches
/// linearly.
constexpr std::size_t kMostCurvePoints = 2048;

/// A point of vtkPiecewiseFunction.
struct VtkPoint {
    double x = 0, y = 0, midpoint = 0.5, sharpness = 0;
};
/// A point of vtkColorTransferFunction; sRGB colour, [0,1].
struct VtkColour {
    double x = 0;
    glm::dvec3 colour{0};
    double midpoint = 0.5, sharpness = 0;
};
/// ParaView's names of the spaces in which vtkColorTransferFunction interpolates.
enum class ColourSpace { rgb, hsv, lab, diverging, labCiede2000, step };

/// Points in any order; two at one value are a step. y is clamped to [0,1].
/// @param mostError  of an opacity, where the curve is not linear
std::vector<OpacityPoint> opacityPoints(std::vector<VtkPoint> points, double mostError = kOpacityError);
/// Removes the least important points until `most` are left, at least 2. Returns the largest error of a
/// removed point.
double thinned(std::vector<OpacityPoint>& points, std::size_t most);
std::vector<ColourPoint> colourPoints(std::vector<VtkColour> points, ColourSpace space, bool wrapsHue);

/// Converts functions linear in linear light to ones linear in sRGB.
std::vector<VtkColour> screenColours(const std::vector<ColourPoint>& points);
/// Points with distinct values, as VTK needs them: steps become as steep as doubles allow.
std::vector<VtkPoint> distinct(const std::vector<OpacityPoint>& points);

// ParaView's colour maps as JSON.

std::vector<ForeignPreset> readParaView(const std::string& text, const std::string& where);
ForeignText writeParaView(const Preset& preset);

// 3D Slicer's volume properties.

std::vector<ForeignPreset> readSlicerJson(const std::string& text, const std::string& where);
std::vector<ForeignPreset> readSlicerText(const std::string& text, const std::string& where);
std::vector<ForeignPreset> readSlicerXml(const std::string& text, const std::string& where);
ForeignText writeSlicerJson(const Preset& preset);

} // namespace tessera

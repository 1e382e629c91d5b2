// viewer/presets/foreign_preset.h: transfer functions of other programs' files: 3D Slicer (.vp.json, .vp,
// MRML scenes and presets.xml) and ParaView (JSON). Their colours are sRGB, ours are linear light. Their
// curves may bend between points, ours are linear. Points are added as needed, to within kColourError and
// kOpacityError.
#pragma once

#include "core/scene/scene_presets.h"

#include <string>
#include <vector>

namespace tessera {

enum class PresetFormat { slicerJson, slicerText, slicerXml, paraView };

constexpr double kColourError = 0.5 / 255; // of an sRGB component, between added points
constexpr double kOpacityError = 1e-3;     // of an opacity, where a curve is not linear

/// A preset of another program's file, and the settings that our scenes lack, a sentence each.
struct ForeignPreset {
    Preset preset;
    std::vector<std::string> leftOut;
};

/// All functions of a text in that format, in order; at least one. Slicer's lighting becomes the preset's
/// shading. ParaView's functions over [0,1] are over shares of a range; colours without opacities get
/// ParaView's default, a ramp from 0 to 1. Throws InputError naming where, what was expected and what was
/// found for truncated texts, wrong counts of numbers, numbers that are not finite, and files without a
/// function.
std::vector<ForeignPreset> readForeignPresets(const std::string& text, PresetFormat format,
                                              const std::string& where);

/// A preset in the format slicerJson or paraView, and the settings left out.
struct ForeignText {
    std::string text;
    std::vector<std::string> leftOut;
};
/// Throws InputError for other formats.
ForeignText writeForeignPreset(const Preset& preset, PresetFormat format);

} // namespace tessera

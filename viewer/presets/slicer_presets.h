// viewer/presets/slicer_presets.h: 3D Slicer's volume properties. Private to this room.
#pragma once

#include "viewer/presets/foreign_preset.h"

namespace tessera {

std::vector<ForeignPreset> readSlicerJson(const std::string& text, const std::string& where);
std::vector<ForeignPreset> readSlicerText(const std::string& text, const std::string& where);
std::vector<ForeignPreset> readSlicerXml(const std::string& text, const std::string& where);
ForeignText writeSlicerJson(const Preset& preset);

} // namespace tessera

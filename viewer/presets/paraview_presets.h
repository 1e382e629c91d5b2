// viewer/presets/paraview_presets.h: ParaView's colour maps as JSON. Private to this room.
#pragma once

#include "viewer/presets/foreign_preset.h"

namespace tessera {

std::vector<ForeignPreset> readParaView(const std::string& text, const std::string& where);
ForeignText writeParaView(const Preset& preset);

} // namespace tessera

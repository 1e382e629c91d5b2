// core/scene/transfer_json.h: a transfer function as JSON, the same in scenes and presets:
//   {"scalarOpacityUnitDistance": 1, "scalarOpacity": [[value, opacity], ...],
//    "rgbTransferFunction": [[value, r, g, b], ...],
//    "materials": [{"from": value, "to": value, "ambient": 0.2, ...}, ...],
//    "gradientOpacity": [[length, factor], ...], "gradientOpacityUnit": "mm"}
// Opacity is per scalarOpacityUnitDistance millimetres; colours are linear light in [0,1];
// lengths of gradients are per mm, or, unit "voxel", per mean spacing of the volume.
// Include from .cpp files only.
#pragma once

#include "core/base/json_reader.h"
#include "core/scene/transfer_function.h"

namespace tessera {

/// The keys above.
const std::vector<std::string>& transferKeys();
const std::vector<std::string>& materialKeys();
/// Reads those keys of an object; others are the caller's affair. A missing unit distance is 1 mm, a missing
/// scalarOpacity refused (a forgotten one would draw nothing), missing colours are white.
TransferFunction parseTransfer(const JsonValue& value);
/// The inverse. The function must hold opacities (fromOpacity), not extinctions.
nlohmann::json transferJson(const TransferFunction& function);

} // namespace tessera

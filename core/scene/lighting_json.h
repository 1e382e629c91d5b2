// core/scene/lighting_json.h: lights and ambient occlusion as JSON, as scenes have them:
//   {"lights": [{"kind": "directional", "frame": "patient", "direction": [0, -1, 1], "intensity": 0.8}],
//    "occlusion": {"rays": 32, "radius": 16}}
// Include from .cpp files only.
#pragma once

#include "core/base/json_reader.h"
#include "core/scene/lighting.h"

#include <string>
#include <vector>

namespace tessera {

Lighting parseLighting(const JsonValue& value);
/// The inverse; null where there is nothing to say.
nlohmann::json lightingJson(const Lighting& lighting);

/// Keys: of the object, of a light, of the occlusion, of that of isosurfaces.
const std::vector<std::string>& lightingKeys();
const std::vector<std::string>& lightKeys();
const std::vector<std::string>& occlusionKeys();
const std::vector<std::string>& surfaceOcclusionKeys();

} // namespace tessera

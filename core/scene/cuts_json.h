// core/scene/cuts_json.h: cuts, and cameras that are spelled out, as scenes have them:
//   {"boxes": [{"low": [-90, -40, 0], "high": [90, 120, 250]}],
//    "planes": [{"point": [0, 0, 40], "normal": [0, 1, 0], "keep": "outside"}],
//    "scissors": [{"camera": {...}, "aspect": 1.5, "outline": [[0.2, 0.1], [0.8, 0.1], [0.5, 0.9]]}]}
// Include from .cpp files only.
#pragma once

#include "core/base/json_reader.h"
#include "core/scene/cuts.h"

#include <string>
#include <vector>

namespace tessera {

/// Throws InputError naming the place for what the schema does not know, and for cuts that are none.
Cuts parseCuts(const JsonValue& value);
/// The inverse; null where nothing is cut.
nlohmann::json cutsJson(const Cuts& cuts);

/// A camera in patient space. Keys of other cameras are not looked at.
Camera parseFreeCamera(const JsonValue& value);
nlohmann::json freeCameraJson(const Camera& camera);

/// Keys: of a camera that is spelled out, of the cuts, of each kind.
const std::vector<std::string>& freeCameraKeys();
const std::vector<std::string>& cutsKeys();
const std::vector<std::string>& cropBoxKeys();
const std::vector<std::string>& cutPlaneKeys();
const std::vector<std::string>& scissorsKeys();

} // namespace tessera

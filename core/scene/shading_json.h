// core/scene/shading_json.h: a scene's shading as JSON, for scenes and looks.
#pragma once

#include "core/base/json_reader.h"
#include "core/scene/scene.h"

#include <string>
#include <vector>

namespace tessera {

const std::vector<std::string>& shadingKeys();
/// Throws InputError naming the place for what the schema does not know.
Shading parseShading(const JsonValue& value);

} // namespace tessera

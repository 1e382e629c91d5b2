// core/scene/look.h: lighting presets, in core/scene/looks/*.json: lights, occlusion and material response by
// name. A lighting preset is a look in code and options.
#pragma once

#include "core/scene/scene.h"

#include <string>
#include <vector>

namespace tessera {

/// "plain", "studio", "soft", "dramatic", "endoscope", "soft-1". NAME-1 is what NAME was before it changed.
const std::vector<std::string>& lookNames();
/// Takes a look's light, and of its shading what it says; gradient and whether to shade stay the scene's.
/// Throws InputError, listing the names and the nearest one, for an unknown name.
void applyLook(const std::string& name, Scene& scene);

} // namespace tessera

// core/look.h: named light for pictures, in core/looks/*.json: lights, occlusion and how things answer to
// them.
#pragma once

#include "core/scene.h"

#include <string>
#include <vector>

namespace tessera {

/// "plain", "studio", "soft", "dramatic", "endoscope", "soft-1". NAME-1 is what NAME was before it changed.
const std::vector<std::string>& lookNames();
/// Takes a look's light, and of its shading what it says; gradient and whether to shade stay the scene's.
/// Throws InputError, listing the names and the nearest one, for an unknown name.
void applyLook(const std::string& name, Scene& scene);

} // namespace tessera

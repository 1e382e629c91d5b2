// core/scene/look.h: lighting presets, in core/scene/looks/*.json: lights, occlusion and material response by
// name. In code and files a lighting preset is called a look.
#pragma once

#include "core/scene/scene.h"

#include <string>
#include <vector>

namespace tessera {

/// "plain", "studio", "soft", "dramatic", "endoscope", "soft-1". NAME-1 is an earlier version of NAME.
const std::vector<std::string>& lookNames();
/// Applies a lighting preset's light and the shading that it names; the gradient operator and `shade` stay
/// the scene's. Throws InputError, listing the names and the nearest one, for an unknown name.
void applyLook(const std::string& name, Scene& scene);

} // namespace tessera

// viewer/cli/input/environment_input.h: the file of a scene's environment, read for paths of light.
#pragma once

#include "core/base/budget.h"
#include "core/scene/scene.h"

#include <string>
#include <vector>

namespace tessera {

/// Sets EnvironmentFile::map where the scene's environment names a file that is not read yet.
/// @param notes  what was changed of it, in words, is added
/// @return what the map takes, charged to ram; to be kept as long as the scene's pictures are drawn
/// Throws InputError as readEnvironment() does, and where the program cannot read such files.
Charge readEnvironmentOf(Scene& scene, MemoryBudget& ram, std::vector<std::string>& notes);

} // namespace tessera

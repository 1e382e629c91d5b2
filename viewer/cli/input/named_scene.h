// viewer/cli/input/named_scene.h: the scene of a path that the user named: a scene file's, or the default
// scene of a volume.
#pragma once

#include "core/base/volume.h"
#include "core/scene/scene.h"

#include <filesystem>

namespace tessera {

/// The scene in a file, or one of the volume there, its transfer function not named yet. The volume is not
/// opened. Throws InputError naming a scene file that cannot be read.
Scene sceneOf(const std::filesystem::path& path);

/// A transfer function that nobody named follows from the values' unit: bone-1, which costs the least time,
/// for HU, auto for others.
/// @param info  of the volume's store
void nameFunction(SceneVolume& volume, const VolumeInfo& info);

} // namespace tessera

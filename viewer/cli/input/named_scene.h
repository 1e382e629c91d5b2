// viewer/cli/input/named_scene.h: the scene of a path that the user named: a scene file's, or the default
// scene of a volume.
#pragma once

#include "core/base/volume.h"
#include "core/scene/scene.h"

#include <filesystem>

namespace tessera {

/// The scene in a file, or a scene of the volume there without a transfer function. The volume is not opened.
/// Throws InputError naming a scene file that cannot be read.
Scene sceneOf(const std::filesystem::path& path);

/// The default transfer function by the values' unit: bone-1, the fastest, for HU, auto for others.
/// @param info  of the volume's store
void nameFunction(SceneVolume& volume, const VolumeInfo& info);

} // namespace tessera

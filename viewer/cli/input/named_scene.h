// viewer/cli/input/named_scene.h: the scene of a path that the user named: a scene file's, or the default
// scene of a volume.
#pragma once

#include "core/base/volume.h"
#include "core/scene/scene.h"

#include <cstddef>
#include <filesystem>
#include <string>

namespace tessera {

// Shows a volume of one slice as a slice. From the side it is a line, and would be drawn blank.

/// True of a volume with a single slice along one axis alone.
bool isOneSlice(const VolumeInfo& info);
/// True if the scene shows a volume of one slice as a slice: nothing asks for another picture.
/// @param sideNamed  a camera's fit or projection was requested
bool facesThinVolume(const Scene& scene, bool sideNamed);

/// Without a requested side, the single slice of a volume is shown as a slice, and in modes other than
/// compositing from the side that it faces.
/// @param sideNamed  a camera's fit or projection was requested: then the mode stays
/// @return a note: "one slice: shown as --slice axial"; "" if nothing changed
std::string faceThinVolume(Scene& scene, const VolumeInfo& info, bool sideNamed);

/// Throws InputError naming `where` and the view that shows the slice, if a camera by side (--view) looks
/// along the single slice of a volume. Other cameras are free.
void requireFacingView(const Scene& scene, const VolumeInfo& info, const std::string& where);

/// The scene in a file, or a scene of the volume there without a transfer function. The volume is not opened.
/// Throws InputError naming a scene file that cannot be read.
Scene sceneOf(const std::filesystem::path& path);

/// The same, for volumes that are named later: a scene file without "volumes", and path "", have one without
/// a path.
Scene styleOf(const std::filesystem::path& path);

/// The default transfer function by the values' unit: bone-1, the fastest, for HU, auto for others.
/// @param info  of the volume's store
void nameFunction(SceneVolume& volume, const VolumeInfo& info);
/// The same of a scene's volume. Where its mode shows no transfer function, a preset of CT gives way to auto
/// for values that are not in HU, so that they are not refused for a function without effect.
void nameFunction(Scene& scene, std::size_t volume, const VolumeInfo& info);
/// True if the scene's mode shows the transfer function of a volume: its opacities, light or colours.
bool showsFunction(const Scene& scene, std::size_t volume);

} // namespace tessera

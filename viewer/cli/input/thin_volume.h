// viewer/cli/input/thin_volume.h: shows a volume of one slice as a slice. From the side it is a line, and
// would be drawn blank.
#pragma once

#include "core/base/volume.h"
#include "core/scene/scene.h"

#include <string>

namespace tessera {

/// Where nobody asked for a side, a volume's single slice is looked at as a slice, and in other modes than
/// compositing from where it faces.
/// @param sideNamed  a camera's fit or projection was asked for: then the mode stays
/// @return what to say: "one slice: shown as --slice axial"; "" where nothing changed
std::string faceThinVolume(Scene& scene, const VolumeInfo& info, bool sideNamed);

/// Throws InputError naming `where` and the view that shows the slice, if the scene looks by side (--view)
/// along a volume's single slice. A camera that is spelled out may look as it likes.
void requireFacingView(const Scene& scene, const VolumeInfo& info, const std::string& where);

} // namespace tessera

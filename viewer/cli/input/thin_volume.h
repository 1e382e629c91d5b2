// viewer/cli/input/thin_volume.h: shows a volume of one slice as a slice. From the side it is a line, and
// would be drawn blank.
#pragma once

#include "core/base/volume.h"
#include "core/scene/scene.h"

#include <string>

namespace tessera {

/// Without a requested side, the single slice of a volume is shown as a slice, and in modes other than
/// compositing from the side that it faces.
/// @param sideNamed  a camera's fit or projection was requested: then the mode stays
/// @return a note: "one slice: shown as --slice axial"; "" if nothing changed
std::string faceThinVolume(Scene& scene, const VolumeInfo& info, bool sideNamed);

/// Throws InputError naming `where` and the view that shows the slice, if a camera by side (--view) looks
/// along the single slice of a volume. Other cameras are free.
void requireFacingView(const Scene& scene, const VolumeInfo& info, const std::string& where);

} // namespace tessera

// viewer/input/thin_volume.h: a volume of one slice, which is a line from the side: explained instead of
// drawn blank.
#pragma once

#include "core/scene.h"
#include "core/volume.h"

#include <string>

namespace tessera {

/// Throws InputError, naming `where` and the view that shows the slice, if the scene looks by side (--view)
/// along a volume's single slice. A camera that is spelled out may look as it likes.
void requireFacingView(const Scene& scene, const VolumeInfo& info, const std::string& where);

} // namespace tessera

// viewer/cli/render/volume_place.h: the position of a volume in words, for whoever asked for a picture
// beside it.
#pragma once

#include "core/base/volume.h"
#include "core/scene/scene.h"

#include <string>

namespace tessera {

/// "x from -170 to 169.3, y from -12 to 80 and z from -400 to -1.5 mm": of the box around it, patient space.
std::string placeOf(const VolumeInfo& info);

/// Throws InputError naming `where` for a slice that lies wholly beside the volume, and says where that is.
void requireSliceInVolume(const Scene& scene, const VolumeInfo& info, const std::string& where);

} // namespace tessera

// viewer/cli/render/volume_place.h: the position of a volume in words, for messages about pictures outside
// it.
#pragma once

#include "core/base/volume.h"
#include "core/scene/scene.h"

#include <string>

namespace tessera {

/// "x from -170 to 169.3, y from -12 to 80 and z from -400 to -1.5 mm": its bounding box, patient space.
std::string placeOf(const VolumeInfo& info);

/// Throws InputError naming `where`, with the volume's box, for a slice entirely outside the volume.
void requireSliceInVolume(const Scene& scene, const VolumeInfo& info, const std::string& where);

} // namespace tessera

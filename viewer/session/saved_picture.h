// viewer/session/saved_picture.h: saves a shown picture as a file.
#pragma once

#include "viewer/session/viewing.h"

#include <filesystem>

namespace tessera {

/// Writes it on its background, with its manifest. Throws Error or InputError naming the path.
/// @param scaleBar  drawn into it, for the size that it has
void savePicture(const std::filesystem::path& path, const ShownPicture& picture, bool scaleBar);

} // namespace tessera

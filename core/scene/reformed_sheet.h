// core/scene/reformed_sheet.h: where reformations of a line and its cross-sections lie in one image.
#pragma once

#include "core/scene/reformation.h"

#include <glm/vec2.hpp>
#include <vector>

namespace tessera {

/// Sets where each picture lies (Reformation::from): those along the line side by side; cross-sections, which
/// come last and are of one size, beside them, from top to bottom and in as many columns as they need. Alone
/// they lie in rows.
/// Throws InputError for an image that is wider or higher than a picture may be.
/// Returns the size of the image.
glm::ivec2 layOutPictures(std::vector<Reformation>& pictures);

/// The size of an image that holds them where they lie.
glm::ivec2 sizeOf(const std::vector<Reformation>& pictures);

} // namespace tessera

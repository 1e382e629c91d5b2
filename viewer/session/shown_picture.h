// viewer/session/shown_picture.h: a shown picture's pixels, for the screen and for a file.
#pragma once

#include "core/base/budget.h"
#include "core/image/image.h"
#include "viewer/session/viewing.h"

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

namespace tessera {

// A picture for the screen: on its background, of the window's size, 8-bit sRGB.

/// One pixel after the other, top row first, bytes red, green, blue, 255. A picture of that size has exactly
/// the bytes of its PNG on the background. A smaller one is enlarged by cubic interpolation (Catmull-Rom),
/// clamped to the four pixels around a point, so that edges stay sharp without overshoot.
/// @param background  linear; none: dark grey
/// @param size  at least the image's along each axis
std::vector<std::uint32_t> displayPixels(const Image& image, const std::optional<glm::vec3>& background,
                                         const glm::ivec2& size, int threads);

// Saves shown pictures as a file.

/// Writes them on their backgrounds, with their manifests: one as it is, several as panels of one figure,
/// side by side. Throws Error or InputError naming the path or the budget.
/// @param ram  charged for what is written, not for the pictures
void savePictures(const std::filesystem::path& path, const std::vector<SavedPanel>& panels,
                  MemoryBudget& ram);

} // namespace tessera

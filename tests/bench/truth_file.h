// tests/bench/truth_file.h: references on disk, because one takes minutes: found again by all that they
// depend on, as text, whose digest names the file.
#pragma once

#include "core/image/image.h"
#include "core/scene/scene.h"

#include <filesystem>
#include <functional>
#include <string>

namespace tessera::bench {

/// All that a reference's picture depends on but the program: the volume by its content, transfer function,
/// camera and light, which of the picture's pixels.
/// @param scene  camera and transfer function spelled out
std::string truthKey(const Scene& scene, const std::string& volumeContent, const glm::ivec2& size,
                     int stride);

/// The picture of that key from the folder, or made and put there. Throws InputError for a file that is not
/// whole.
/// @param name  of the scene, for people
Image truthFromFile(const std::filesystem::path& folder, const std::string& name, const std::string& key,
                    const std::function<Image()>& make);

} // namespace tessera::bench

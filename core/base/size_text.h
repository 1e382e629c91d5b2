// core/base/size_text.h: sizes as people type them: "640x480".
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>

namespace tessera {

/// "640x480". Throws InputError naming `where` for anything but whole numbers from 1 to `largest`.
glm::ivec2 parseImageSize(const std::string& text, const std::string& where, int largest);
/// "256x192x300". The same for three axes.
glm::ivec3 parseVolumeSize(const std::string& text, const std::string& where, int largest);

} // namespace tessera

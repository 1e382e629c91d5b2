// core/base/embedded.h: text files compiled into the program (cmake/EmbedFiles.cmake), by name.
#pragma once

#include <map>
#include <string_view>

namespace tessera {

using EmbeddedFiles = std::map<std::string_view, std::string_view>;

} // namespace tessera

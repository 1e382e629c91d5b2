// bricking/import/source/printable_name.h: a file's name as a line of text may show it.
#pragma once

#include "core/printable_text.h"

#include <filesystem>
#include <string>

namespace tessera {

inline std::string printableName(const std::filesystem::path& path) {
    return printable(path.string());
}

} // namespace tessera

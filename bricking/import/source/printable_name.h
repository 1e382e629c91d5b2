// bricking/import/source/printable_name.h: a file name made printable, for one line of text.
#pragma once

#include "core/base/shown_text.h"

#include <filesystem>
#include <string>

namespace tessera {

inline std::string printableName(const std::filesystem::path& path) {
    return printable(path.string());
}

} // namespace tessera

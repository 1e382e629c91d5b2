// bricking/import/files/stack/imagej_lines.h: words of the description that ImageJ writes into TIFF files.
// Private to stacks.
#pragma once

#include "bricking/import/files/header_words.h"

#include <string>
#include <string_view>

namespace tessera {

inline bool isOfImageJ(std::string_view description) {
    return description.starts_with("ImageJ=");
}

/// Of "key=value", which has a line of its own; "" none.
inline std::string imageJLine(std::string_view text, const std::string& key) {
    const std::string begin = "\n" + key + "=";
    const std::size_t at = text.find(begin);
    if (at == std::string_view::npos)
        return "";
    const std::string_view rest = text.substr(at + begin.size());
    return std::string(withoutBlanks(rest.substr(0, rest.find('\n'))));
}

} // namespace tessera

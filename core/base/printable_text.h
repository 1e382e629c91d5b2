// core/base/printable_text.h: makes external text (file names, header tags, arguments) safe to print. A
// terminal obeys control characters, and a file name may hold any.
#pragma once

#include <string>
#include <string_view>

namespace tessera {

/// One line without control characters. UTF-8 stays. C0, DEL and C1 controls become escapes like "\x1b", as
/// do bytes that are not UTF-8. Line and paragraph separators and marks of writing direction become escapes
/// like "\u202e".
std::string printable(std::string_view text);
/// The same for text of several lines: line feeds stay.
std::string printableLines(std::string_view text);

} // namespace tessera

// core/base/printable_text.h: makes text from outside (file names, header tags, arguments) fit to be printed.
// A terminal obeys control characters, and a file name may hold any.
#pragma once

#include <string>
#include <string_view>

namespace tessera {

/// One line that a terminal shows and does not obey. UTF-8 stays. C0, DEL and C1 controls become "\x1b", as
/// do bytes that are no UTF-8. Line and paragraph separators and the marks that turn the direction of writing
/// become "\u202e".
std::string printable(std::string_view text);
/// The same for text of several lines: line feeds stay.
std::string printableLines(std::string_view text);

} // namespace tessera

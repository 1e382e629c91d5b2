// core/base/shown_text.h: text for people: numbers, and external text made safe to print. A terminal obeys
// control characters, and file names, header tags and arguments may hold any.
#pragma once

#include <string>
#include <string_view>

namespace tessera {

/// At most `digits` significant digits, no padding, and every digit before the point: "1.07", "10012". A
/// power of ten only below 1e-4 and from 1e15 on.
std::string numberText(double value, int digits = 4);

/// In three digits, with its unit, if any: "1024 HU", "41.2 HU".
std::string valueText(double value, const std::string& unit);

/// A length in tenths of a millimetre: "0 mm", "7.2 mm", "1204.5 mm".
std::string mmText(double mm);

/// One line without control characters. UTF-8 stays. C0, DEL and C1 controls become escapes like "\x1b", as
/// do bytes that are not UTF-8. Line and paragraph separators and marks of writing direction become escapes
/// like "\u202e".
std::string printable(std::string_view text);
/// The same for text of several lines: line feeds stay.
std::string printableLines(std::string_view text);

} // namespace tessera

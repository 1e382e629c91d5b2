// core/base/decimal.h: numbers in text as people and tables write them.
#pragma once

#include <optional>
#include <string_view>

namespace tessera {

/// A finite number in decimal digits with a point, a sign and an exponent, blanks before it. None: anything
/// else, so 0x1F, 010, nan, inf, and 1,5 with a comma.
std::optional<double> decimalNumber(std::string_view text);
/// "1,5": a number, if its comma were a point.
bool hasDecimalComma(std::string_view text);

} // namespace tessera

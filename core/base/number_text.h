// core/base/number_text.h: numbers as text for people.
#pragma once

#include <string>

namespace tessera {

/// At most `digits` significant digits, no padding, and every digit before the point: "1.07", "10012". A
/// power of ten only below 1e-4 and from 1e15 on.
std::string numberText(double value, int digits = 4);

/// In three digits, with its unit, if any: "1024 HU", "41.2 HU".
std::string valueText(double value, const std::string& unit);

/// A length in tenths of a millimetre: "0 mm", "7.2 mm", "1204.5 mm".
std::string mmText(double mm);

} // namespace tessera

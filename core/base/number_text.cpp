// core/base/number_text.cpp: see number_text.h.
#include "core/base/number_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tessera {
namespace {

std::string withDecimals(double value, int decimals) {
    char text[64]; // of at most 16 digits before the point
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
    std::string shown = text;
    if (shown.find('.') != std::string::npos) {
        shown.erase(shown.find_last_not_of('0') + 1);
        if (shown.back() == '.')
            shown.pop_back();
    }
    return shown == "-0" ? "0" : shown;
}

} // namespace

std::string numberText(double value, int digits) {
    constexpr double kPowersFrom = 1e15;
    const double size = std::abs(value);
    if (size >= 1 && size < kPowersFrom) {
        const int before = static_cast<int>(std::floor(std::log10(size))) + 1;
        return withDecimals(value, std::max(0, digits - before));
    }
    char text[64];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

std::string valueText(double value, const std::string& unit) {
    return numberText(value, 3) + (unit.empty() ? "" : " " + unit);
}

std::string mmText(double mm) {
    return withDecimals(mm, 1) + " mm";
}

} // namespace tessera

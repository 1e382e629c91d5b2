// core/base/shown_text.cpp: see shown_text.h.
#include "core/base/shown_text.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
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

namespace {

struct Character {
    std::uint32_t code = 0;
    std::size_t bytes = 0; // 0: no UTF-8
};

/// The character at the start of text, which is not empty. No overlong forms, no surrogates.
Character firstCharacter(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char lead = byte(0);
    if (lead < 0x80)
        return {lead, 1};
    const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
    if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes)
        return {};
    std::uint32_t code = lead & (0x7Fu >> bytes);
    for (std::size_t i = 1; i < bytes; ++i) {
        if ((byte(i) & 0xC0) != 0x80)
            return {};
        code = code << 6 | (byte(i) & 0x3Fu);
    }
    const bool overlong = (bytes == 3 && code < 0x800) || (bytes == 4 && code < 0x10000);
    if (overlong || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF))
        return {};
    return {code, bytes};
}

bool isControl(std::uint32_t code) {
    return code < 0x20 || (code >= 0x7F && code < 0xA0);
}
/// Characters that change the position of the following text.
bool movesText(std::uint32_t code) {
    return code == 0x061C || code == 0x200E || code == 0x200F || (code >= 0x2028 && code <= 0x202E) ||
           (code >= 0x2066 && code <= 0x2069);
}

std::string escaped(std::string_view text, bool keepLines) {
    std::string out;
    out.reserve(text.size());
    const auto escape = [&out](const char* format, std::uint32_t code) {
        char word[16];
        std::snprintf(word, sizeof word, format, code);
        out += word;
    };
    while (!text.empty()) {
        const Character c = firstCharacter(text);
        const std::size_t bytes = c.bytes ? c.bytes : 1;
        if (!c.bytes)
            escape("\\x%02x", static_cast<unsigned char>(text[0]));
        else if (isControl(c.code) && !(keepLines && c.code == '\n'))
            escape("\\x%02x", c.code);
        else if (movesText(c.code))
            escape("\\u%04x", c.code);
        else
            out += text.substr(0, bytes);
        text.remove_prefix(bytes);
    }
    return out;
}

} // namespace

std::string printable(std::string_view text) {
    return escaped(text, false);
}

std::string printableLines(std::string_view text) {
    return escaped(text, true);
}

} // namespace tessera

// bricking/import/files/stack/xml_tags.cpp: see xml_tags.h.
#include "bricking/import/files/stack/xml_tags.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace tessera {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

/// Behind the '>' of a tag that begins at `at`; npos: it has none. Quotation marks may hold one.
std::size_t endOfTag(std::string_view text, std::size_t at) {
    char quote = 0;
    for (; at < text.size(); ++at) {
        const char c = text[at];
        if (quote != 0)
            quote = c == quote ? '\0' : quote;
        else if (c == '"' || c == '\'')
            quote = c;
        else if (c == '>')
            return at + 1;
    }
    return std::string_view::npos;
}

/// Behind what is no tag ("<?...?>", "<!...>") and begins at `at`; `at` for a tag.
std::size_t behindOther(std::string_view text, std::size_t at) {
    const auto behind = [&](std::string_view end) {
        const std::size_t found = text.find(end, at);
        return found == std::string_view::npos ? text.size() : found + end.size();
    };
    const std::string_view rest = text.substr(at);
    return rest.starts_with("<!--")        ? behind("-->")
           : rest.starts_with("<![CDATA[") ? behind("]]>")
           : rest.starts_with("<?")        ? behind("?>")
           : rest.starts_with("<!")        ? behind(">")
                                           : at;
}

void appendUtf8(std::string& out, std::uint32_t code) {
    const auto byte = [&](std::uint32_t value) { out += static_cast<char>(value); };
    if (code < 0x80) {
        byte(code);
    } else if (code < 0x800) {
        byte(0xC0 | code >> 6), byte(0x80 | (code & 63));
    } else {
        byte(0xE0 | (code >> 12 & 15)), byte(0x80 | (code >> 6 & 63)), byte(0x80 | (code & 63));
    }
}

std::string withoutEntities(std::string_view text) {
    static constexpr std::array kEntities = {std::pair("amp", '&'), std::pair("lt", '<'),
                                             std::pair("gt", '>'), std::pair("quot", '"'),
                                             std::pair("apos", '\'')};
    std::string out;
    while (!text.empty()) {
        constexpr std::size_t kMostEntity = 12; // "&#x0010FFFF;"
        const std::size_t end =
            text.front() == '&' ? text.substr(0, kMostEntity).find(';') : std::string_view::npos;
        if (end == std::string_view::npos) {
            out += text.front();
            text.remove_prefix(1);
            continue;
        }
        std::string_view name = text.substr(1, end - 1);
        text.remove_prefix(end + 1);
        if (name.starts_with('#')) {
            const bool isHexadecimal = name.starts_with("#x");
            name.remove_prefix(isHexadecimal ? 2 : 1);
            std::uint32_t code = 0;
            std::from_chars(name.data(), name.data() + name.size(), code, isHexadecimal ? 16 : 10);
            appendUtf8(out, code);
        } else if (const auto* const row = std::ranges::find_if(
                       kEntities, [&](const auto& entity) { return name == entity.first; });
                   row != kEntities.end()) {
            out += row->second;
        }
    }
    return out;
}

} // namespace

std::vector<XmlTag> xmlTagsOf(std::string_view text) {
    std::vector<XmlTag> tags;
    for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at)) {
        if (const std::size_t behind = behindOther(text, at); behind != at) {
            at = behind;
            continue;
        }
        const std::size_t end = endOfTag(text, at);
        if (end == std::string_view::npos)
            break;
        XmlTag tag;
        std::string_view inside = text.substr(at + 1, end - at - 2);
        if (inside.starts_with('/')) {
            tag.opens = false, tag.closes = true;
            inside.remove_prefix(1);
        } else if (inside.ends_with('/')) {
            tag.closes = true;
            inside.remove_suffix(1);
        }
        tag.name = inside.substr(0, inside.find_first_of(kBlanks));
        tag.attributes = inside.substr(tag.name.size());
        if (const std::size_t colon = tag.name.find(':'); colon != std::string_view::npos)
            tag.name.remove_prefix(colon + 1);
        tag.text = text.substr(end, text.find('<', end) - end);
        tags.push_back(tag);
        at = end;
    }
    return tags;
}

std::string xmlAttribute(const XmlTag& tag, std::string_view key) {
    std::string_view rest = tag.attributes;
    for (std::size_t at = rest.find('='); at != std::string_view::npos; at = rest.find('=')) {
        std::string_view name = rest.substr(0, at);
        name.remove_prefix(std::min(name.find_first_not_of(kBlanks), name.size()));
        name = name.substr(0, name.find_first_of(kBlanks));
        rest.remove_prefix(at + 1);
        rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
        if (rest.empty() || (rest.front() != '"' && rest.front() != '\''))
            return "";
        const std::size_t end = rest.find(rest.front(), 1);
        if (end == std::string_view::npos)
            return "";
        if (name == key)
            return withoutEntities(rest.substr(1, end - 1));
        rest.remove_prefix(end + 1);
    }
    return "";
}

} // namespace tessera

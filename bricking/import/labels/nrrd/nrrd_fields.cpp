// bricking/import/labels/nrrd/nrrd_fields.cpp: see nrrd_fields.h.
#include "bricking/import/labels/nrrd/nrrd_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <system_error>

namespace tessera {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

template <class T> std::optional<T> numberOf(std::string_view text) {
    text = withoutBlanks(text);
    if (text.starts_with('+') && !text.starts_with("+-"))
        text.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

} // namespace

std::string_view withoutBlanks(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos)
        return {};
    return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

std::string lowered(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return out;
}

std::string nrrdFieldName(std::string_view text) {
    std::string name = lowered(text);
    std::erase_if(name, [](char c) { return kBlanks.find(c) != std::string_view::npos; });
    return name;
}

bool isNrrdField(const std::string& name) {
    static const std::set<std::string> known = {
        "dimension",       "type",       "blocksize",   "encoding",        "endian",
        "content",         "min",        "max",         "oldmin",          "oldmax",
        "datafile",        "lineskip",   "byteskip",    "number",          "sampleunits",
        "sizes",           "spacings",   "thicknesses", "axismins",        "axismaxs",
        "centers",         "centerings", "labels",      "units",           "kinds",
        "space",           "spaceunits", "spaceorigin", "spacedirections", "spacedimension",
        "measurementframe"};
    return known.contains(name);
}

std::optional<FileType> nrrdTypeOf(const std::string& text) {
    static const std::map<std::string, FileType> types = {{"signed char", FileType::i8},
                                                          {"int8", FileType::i8},
                                                          {"int8_t", FileType::i8},
                                                          {"uchar", FileType::u8},
                                                          {"unsigned char", FileType::u8},
                                                          {"uint8", FileType::u8},
                                                          {"uint8_t", FileType::u8},
                                                          {"short", FileType::i16},
                                                          {"short int", FileType::i16},
                                                          {"signed short", FileType::i16},
                                                          {"signed short int", FileType::i16},
                                                          {"int16", FileType::i16},
                                                          {"int16_t", FileType::i16},
                                                          {"ushort", FileType::u16},
                                                          {"unsigned short", FileType::u16},
                                                          {"unsigned short int", FileType::u16},
                                                          {"uint16", FileType::u16},
                                                          {"uint16_t", FileType::u16},
                                                          {"int", FileType::i32},
                                                          {"signed int", FileType::i32},
                                                          {"int32", FileType::i32},
                                                          {"int32_t", FileType::i32},
                                                          {"uint", FileType::u32},
                                                          {"unsigned int", FileType::u32},
                                                          {"uint32", FileType::u32},
                                                          {"uint32_t", FileType::u32},
                                                          {"longlong", FileType::i64},
                                                          {"long long", FileType::i64},
                                                          {"long long int", FileType::i64},
                                                          {"signed long long", FileType::i64},
                                                          {"signed long long int", FileType::i64},
                                                          {"int64", FileType::i64},
                                                          {"int64_t", FileType::i64},
                                                          {"ulonglong", FileType::u64},
                                                          {"unsigned long long", FileType::u64},
                                                          {"unsigned long long int", FileType::u64},
                                                          {"uint64", FileType::u64},
                                                          {"uint64_t", FileType::u64},
                                                          {"float", FileType::f32},
                                                          {"double", FileType::f64}};
    const auto at = types.find(text);
    return at == types.end() ? std::nullopt : std::optional(at->second);
}

std::optional<std::int64_t> wholeNumberOf(std::string_view text) {
    return numberOf<std::int64_t>(text);
}

std::optional<double> realNumberOf(std::string_view text) {
    return numberOf<double>(text);
}

std::optional<glm::dvec3> nrrdVectorOf(std::string_view text) {
    text = withoutBlanks(text);
    if (!text.starts_with('(') || !text.ends_with(')') || std::count(text.begin(), text.end(), ',') != 2)
        return std::nullopt;
    text = text.substr(1, text.size() - 2);
    glm::dvec3 vector{0};
    for (int i = 0; i < 3; ++i) {
        const std::size_t end = std::min(text.find(','), text.size());
        const std::optional<double> value = realNumberOf(text.substr(0, end));
        if (!value || !std::isfinite(*value))
            return std::nullopt;
        vector[i] = *value;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return vector;
}

std::vector<std::string> wordsOf(std::string_view text) {
    std::vector<std::string> words;
    for (;;) {
        const std::size_t begin = text.find_first_not_of(kBlanks);
        if (begin == std::string_view::npos)
            return words;
        text.remove_prefix(begin);
        const std::size_t end = std::min(text.find_first_of(kBlanks), text.size());
        words.emplace_back(text.substr(0, end));
        text.remove_prefix(end);
    }
}

std::vector<std::string> vectorsOf(std::string_view text) {
    std::string joined;
    bool isInside = false;
    for (const char c : text) {
        isInside = c == '(' || (isInside && c != ')');
        const bool isBlank = kBlanks.find(c) != std::string_view::npos;
        if (c == '(')
            joined += ' '; // "(1,0,0)(0,1,0)"
        if (!(isInside && isBlank))
            joined += c;
    }
    return wordsOf(joined);
}

std::vector<std::string> textsOf(std::string_view text) {
    std::vector<std::string> texts;
    for (std::size_t begin = text.find('"'); begin != std::string_view::npos;) {
        const std::size_t end = text.find('"', begin + 1);
        if (end == std::string_view::npos)
            break;
        texts.emplace_back(text.substr(begin + 1, end - begin - 1));
        begin = text.find('"', end + 1);
    }
    return texts;
}

std::optional<std::string> numberedName(const std::string& pattern, std::int64_t number) {
    const std::size_t begin = pattern.find('%');
    if (begin == std::string::npos)
        return std::nullopt;
    std::size_t end = begin + 1;
    const bool hasZeros = end < pattern.size() && pattern[end] == '0';
    std::size_t width = 0;
    constexpr std::size_t kMostWidth = 20;
    for (; end < pattern.size() && pattern[end] >= '0' && pattern[end] <= '9'; ++end)
        width = std::min(kMostWidth, 10 * width + static_cast<std::size_t>(pattern[end] - '0'));
    if (end == pattern.size() || std::string_view("diu").find(pattern[end]) == std::string_view::npos ||
        pattern.find('%', end) != std::string::npos)
        return std::nullopt;
    std::string digits = std::to_string(number);
    if (digits.size() < width)
        digits.insert(0, width - digits.size(), hasZeros ? '0' : ' ');
    return pattern.substr(0, begin) + digits + pattern.substr(end + 1);
}

} // namespace tessera

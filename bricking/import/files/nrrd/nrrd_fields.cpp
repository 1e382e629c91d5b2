// bricking/import/files/nrrd/nrrd_fields.cpp: see nrrd_fields.h.
#include "bricking/import/files/nrrd/nrrd_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <system_error>

namespace tessera {
namespace {
constexpr std::string_view kFieldBlanks = " \t\r\v\f";
}

std::string nrrdFieldName(std::string_view text) {
    std::string name = lowered(text);
    std::erase_if(name, [](char c) { return kFieldBlanks.find(c) != std::string_view::npos; });
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

std::vector<std::string> vectorsOf(std::string_view text) {
    std::string joined;
    bool isInside = false;
    for (const char c : text) {
        isInside = c == '(' || (isInside && c != ')');
        const bool isBlank = kFieldBlanks.find(c) != std::string_view::npos;
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

} // namespace tessera

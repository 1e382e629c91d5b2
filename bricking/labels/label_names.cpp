// bricking/labels/label_names.cpp: see label_names.h. Files of names: label_names_file.cpp.
#include "bricking/labels/label_names.h"

#include "bricking/labels/label_names_text.h"
#include "core/base/embedded.h"
#include "core/base/names.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/common.hpp>
#include <map>
#include <numbers>
#include <set>
#include <system_error>
#include <utility>

namespace tessera {

namespace label_names {
const EmbeddedFiles& embeddedFiles(); // generated from bricking/labels/names/*.json
}

namespace {

constexpr std::string_view kGroup = "group:";

char lowerCase(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

std::string inLowerCase(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), lowerCase);
    return out;
}

/// Bytes of the first character of UTF-8 text that is not empty.
std::size_t firstCharacter(std::string_view text) {
    std::size_t bytes = 1;
    while (bytes < text.size() && (static_cast<unsigned char>(text[bytes]) & 0xC0) == 0x80)
        ++bytes;
    return bytes;
}

/// In time of text times pattern: at a fault only the last * takes one character more.
bool matchesGlob(std::string_view text, std::string_view pattern) {
    std::optional<std::pair<std::string_view, std::string_view>>
        retry; // of text, of the pattern behind its *
    for (;;) {
        if (!pattern.empty() && pattern.front() == '*') {
            pattern.remove_prefix(1);
            retry.emplace(text, pattern);
        } else if (!text.empty() && !pattern.empty() && pattern.front() == '?') {
            text.remove_prefix(firstCharacter(text));
            pattern.remove_prefix(1);
        } else if (!text.empty() && !pattern.empty() &&
                   lowerCase(text.front()) == lowerCase(pattern.front())) {
            text.remove_prefix(1);
            pattern.remove_prefix(1);
        } else if (text.empty() && pattern.empty()) {
            return true;
        } else if (retry && !retry->first.empty()) {
            retry->first.remove_prefix(firstCharacter(retry->first));
            text = retry->first;
            pattern = retry->second;
        } else {
            return false;
        }
    }
}

bool startsWithGroup(std::string_view pattern) {
    return inLowerCase(pattern.substr(0, kGroup.size())) == kGroup;
}

void take(const LabelName& from, Label& label) {
    if (!from.name.empty())
        label.name = from.name;
    if (!from.group.empty())
        label.group = from.group;
    if (from.colour)
        label.colour = from.colour;
}

/// Linear Rec. 709 of Oklab (B. Ottosson, 2020); parts may lie outside of [0,1].
glm::dvec3 linearFromOklab(double lightness, double a, double b) {
    const double l = lightness + 0.3963377774 * a + 0.2158037573 * b,
                 m = lightness - 0.1055613458 * a - 0.0638541728 * b,
                 s = lightness - 0.0894841775 * a - 1.2914855480 * b;
    const double l3 = l * l * l, m3 = m * m * m, s3 = s * s * s;
    return {4.0767416621 * l3 - 3.3077115913 * m3 + 0.2309699292 * s3,
            -1.2684380046 * l3 + 2.6097574011 * m3 - 0.3413193965 * s3,
            -0.0041960863 * l3 - 0.7034186147 * m3 + 1.7076147010 * s3};
}

} // namespace

const std::vector<LabelName>& totalSegmentatorNames() {
    static const std::vector<LabelName> names = labelNamesOfJson(
        std::string(label_names::embeddedFiles().at("totalsegmentator.json")), "totalsegmentator.json");
    return names;
}

void applyNames(LabelTable& table, std::span<const LabelName> names) {
    std::map<std::uint32_t, const LabelName*> byValue;
    std::map<std::string, const LabelName*> byName;
    for (const LabelName& name : names)
        if (name.value)
            byValue.emplace(*name.value, &name);
        else
            byName.emplace(inLowerCase(name.name), &name);
    for (Label& label : table.labels)
        if (const auto of = byValue.find(label.value); of != byValue.end())
            take(*of->second, label);
        else if (const auto named = byName.find(inLowerCase(label.name)); named != byName.end())
            take({{}, "", named->second->group, named->second->colour}, label);
}

void applyKnownNames(LabelTable& table) {
    std::map<std::string, const LabelName*> known;
    for (const LabelName& name : totalSegmentatorNames())
        known.emplace(inLowerCase(name.name), &name);
    for (Label& label : table.labels) {
        const auto at = known.find(inLowerCase(label.name));
        if (at == known.end())
            continue;
        if (label.group.empty())
            label.group = at->second->group;
        if (!label.colour)
            label.colour = at->second->colour;
    }
}

glm::vec3 labelColour(std::uint32_t value) {
    // Hues by the golden angle: 2^32 / golden ratio of a turn, in whole numbers.
    constexpr std::uint32_t kGoldenTurn = 2654435769;
    // Values whose hues are near (5, 8, 13, 21, ... apart) have other lightnesses: 11 levels, in steps of 3.
    constexpr double kDarkest = 0.60, kLightest = 0.86;
    constexpr double kChroma = 0.17;
    const double hue =
        2 * std::numbers::pi * static_cast<double>(static_cast<std::uint32_t>(value * kGoldenTurn)) / 0x1p32;
    const double lightness = kDarkest + (kLightest - kDarkest) * (value % 11 * 3 % 11) / 10;
    glm::dvec3 rgb(0);
    for (double chroma = kChroma;; chroma *= 0.9) { // paler until the display has it
        rgb = linearFromOklab(lightness, chroma * std::cos(hue), chroma * std::sin(hue));
        if (std::min({rgb.x, rgb.y, rgb.z}) >= 0 && std::max({rgb.x, rgb.y, rgb.z}) <= 1)
            break;
    }
    return glm::vec3(rgb);
}

namespace {

bool isWholeNumber(std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

} // namespace

bool labelMatches(const Label& label, std::string_view pattern) {
    if (pattern.empty())
        return false;
    if (startsWithGroup(pattern) && matchesGlob(label.group, pattern.substr(kGroup.size())))
        return !label.group.empty();
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(pattern.data(), pattern.data() + pattern.size(), value);
    if (error == std::errc{} && end == pattern.data() + pattern.size() && value == label.value)
        return true;
    return matchesGlob(label.name, pattern);
}

LabelMatcher::LabelMatcher(std::span<const Label> labels) : labels_(labels) {
    for (std::size_t number = 0; number < labels.size(); ++number)
        if (isWholeNumber(labels[number].name))
            namedByNumbers_.push_back(number);
}

std::size_t LabelMatcher::numberOfValue(std::string_view pattern) const {
    if (!isWholeNumber(pattern))
        return kNoNumber;
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(pattern.data(), pattern.data() + pattern.size(), value);
    const auto at = std::lower_bound(labels_.begin(), labels_.end(), value,
                                     [](const Label& label, std::uint32_t v) { return label.value < v; });
    const bool isThere = error == std::errc{} && at != labels_.end() && at->value == value;
    return isThere ? static_cast<std::size_t>(at - labels_.begin()) : labels_.size();
}

std::vector<std::string> nearestNames(const LabelTable& table, std::string_view pattern, std::size_t most) {
    std::set<std::string> known;
    for (const Label& label : table.labels)
        if (!startsWithGroup(pattern))
            known.insert(label.name);
        else if (!label.group.empty())
            known.insert(std::string(kGroup) + label.group);
    std::string word = inLowerCase(pattern);
    std::erase_if(word, [](char c) { return c == '*' || c == '?'; });
    // Names that hold the word come first, short ones before; then those that differ in the fewest letters.
    constexpr std::size_t kBehindAll = std::size_t{1} << 32;
    std::vector<std::pair<std::size_t, std::string>> ranked;
    for (const std::string& name : known) {
        const bool holdsIt = !word.empty() && inLowerCase(name).find(word) != std::string::npos;
        ranked.emplace_back(holdsIt ? name.size() : kBehindAll + editDistance(word, name), name);
    }
    std::stable_sort(ranked.begin(), ranked.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::string> nearest;
    for (std::size_t i = 0; i < std::min(most, ranked.size()); ++i)
        nearest.push_back(std::move(ranked[i].second));
    return nearest;
}

} // namespace tessera

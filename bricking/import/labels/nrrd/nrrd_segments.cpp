// bricking/import/labels/nrrd/nrrd_segments.cpp: see nrrd_segments.h.
#include "bricking/import/labels/nrrd/nrrd_segments.h"

#include "bricking/import/files/nrrd/nrrd_fields.h"
#include "core/base/error.h"
#include "core/base/shown_text.h"
#include "core/image/colour.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>
#include <string_view>

namespace tessera {
namespace {

struct Segment {
    std::int64_t number = 0; // N
    std::string name, group;
    std::optional<std::uint32_t> value;
    std::optional<int> layer;
    std::optional<glm::vec3> colour;
};

std::int64_t inRange(const std::string& text, const std::string& key, std::int64_t least, std::int64_t most,
                     const std::string& where) {
    const std::optional<std::int64_t> value = wholeNumberOf(text);
    if (!value || *value < least || *value > most)
        throw badFile(where,
                      printable(key) + " as a whole number from " + std::to_string(least) + " to " +
                          std::to_string(most),
                      "\"" + printable(text.substr(0, 40)) + "\"");
    return *value;
}

glm::vec3 colourOf(const std::string& text, const std::string& key, const std::string& where) {
    const std::vector<std::string> words = wordsOf(text);
    glm::vec3 colour{0};
    for (std::size_t i = 0; i < 3; ++i) {
        const std::optional<double> part = i < words.size() ? realNumberOf(words[i]) : std::nullopt;
        if (words.size() != 3 || !part || !(*part >= 0 && *part <= 1))
            throw badFile(where, printable(key) + " of three numbers from 0 to 1",
                          "\"" + printable(text.substr(0, 40)) + "\"");
        colour[static_cast<int>(i)] = static_cast<float>(linearFromSrgb(*part));
    }
    return colour;
}

/// The meaning of the category in "TerminologyEntry:CONTEXT~SCHEME^VALUE^MEANING~...|..."; "" none.
std::string categoryOf(std::string_view tags) {
    constexpr std::string_view kEntry = "TerminologyEntry:";
    const std::size_t begin = tags.find(kEntry);
    if (begin == std::string_view::npos)
        return "";
    std::string_view entry = tags.substr(begin + kEntry.size());
    entry = entry.substr(0, entry.find('|'));
    const auto part = [](std::string_view text, char between, int number) {
        for (int i = 0; i < number; ++i) {
            const std::size_t at = text.find(between);
            if (at == std::string_view::npos)
                return std::string_view();
            text.remove_prefix(at + 1);
        }
        return text.substr(0, text.find(between));
    };
    return printable(withoutBlanks(part(part(entry, '~', 1), '^', 2)));
}

std::vector<Segment> describedSegments(const std::map<std::string, std::string>& pairs, int layers,
                                       const std::string& where) {
    constexpr std::string_view kPrefix = "Segment";
    constexpr std::int64_t kMostSegments = 65535;
    std::map<std::int64_t, Segment> segments;
    for (const auto& [key, value] : pairs) {
        const std::size_t line = key.find('_');
        if (!key.starts_with(kPrefix) || line == std::string::npos)
            continue;
        const std::string digits = key.substr(kPrefix.size(), line - kPrefix.size());
        if (digits.empty() || digits.find_first_not_of("0123456789") != std::string::npos)
            continue; // Segmentation_...
        const std::int64_t number = inRange(digits, key, 0, kMostSegments, where);
        Segment& segment = segments[number];
        segment.number = number;
        const std::string field = key.substr(line + 1);
        if (field == "Name")
            segment.name = printable(withoutBlanks(value));
        else if (field == "LabelValue")
            segment.value = static_cast<std::uint32_t>(
                inRange(value, key, 1, std::numeric_limits<std::uint32_t>::max(), where));
        else if (field == "Layer")
            segment.layer = static_cast<int>(inRange(value, key, 0, layers - 1, where));
        else if (field == "Color")
            segment.colour = colourOf(value, key, where);
        else if (field == "Tags")
            segment.group = categoryOf(value);
    }
    std::vector<Segment> all;
    for (auto& [number, segment] : segments)
        all.push_back(std::move(segment));
    return all;
}

} // namespace

NrrdSegments nrrdSegmentsOf(const std::map<std::string, std::string>& pairs, int layers,
                            const std::string& where) {
    NrrdSegments out;
    out.layers.resize(static_cast<std::size_t>(layers));
    std::vector<Segment> segments = describedSegments(pairs, layers, where);
    std::set<std::uint32_t> taken;
    std::uint32_t highest = 0;
    for (const Segment& segment : segments)
        highest = std::max(highest, segment.value.value_or(1));
    std::size_t renumbered = 0;
    for (Segment& segment : segments) {
        const std::int64_t layer = segment.layer ? *segment.layer : layers > 1 ? segment.number : 0;
        if (layer >= layers)
            throw badFile(where, "a layer for every segment",
                          "segment " + std::to_string(segment.number) + " of a file of " +
                              std::to_string(layers) + " layers");
        const std::uint32_t number = segment.value.value_or(1);
        std::uint32_t value = number;
        if (!taken.insert(value).second) {
            while (highest == std::numeric_limits<std::uint32_t>::max() || taken.contains(highest + 1))
                highest = highest == std::numeric_limits<std::uint32_t>::max() ? 0 : highest + 1;
            value = ++highest;
            taken.insert(value);
            renumbered += segment.value ? 1 : 0;
        }
        if (!out.layers[static_cast<std::size_t>(layer)].emplace(number, value).second)
            throw badFile(where, "segments of one layer with different label values",
                          "several of layer " + std::to_string(layer) + " with " + std::to_string(number));
        out.labels.push_back({value, segment.name.empty() ? "label " + std::to_string(value) : segment.name,
                              segment.group, segment.colour});
    }
    if (renumbered > 0)
        out.notes.push_back("layers share label values: " + std::to_string(renumbered) +
                            " segments have other values here than in the file");
    std::sort(out.labels.begin(), out.labels.end(),
              [](const Label& a, const Label& b) { return a.value < b.value; });
    return out;
}

} // namespace tessera

// bricking/labels/label_names.h: names, groups and colours of labels apart from the file of labels: from
// colour tables, from the shipped table of anatomy, by number; and the patterns by which users choose labels.
#pragma once

#include "bricking/labels/label_table.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

struct LabelName {
    std::optional<std::uint32_t> value = {}; // never 0; nullopt: known by its name alone
    std::string name;                        // UTF-8; "" none
    std::string group = {};                  // "" none
    std::optional<glm::vec3> colour = {};    // linear light, [0,1], Rec. 709 primaries
    bool operator==(const LabelName&) const = default;
};

/// Reads, by a file's name and content:
/// - colour tables of 3D Slicer and FreeSurfer (.ctbl, .txt): lines "VALUE NAME R G B A";
/// - label descriptions of ITK-SNAP (.label, .txt): lines VALUE R G B A VISIBLE MESH "NAME";
/// - .csv: "value,name,r,g,b" or "value,name,#rrggbb", or other columns under a header with these words
///   (also group, color, LabelValue, Color_R);
/// - .json: {"NAME": "#rrggbb" or VALUE, ...}, or a list of objects with value, name, colour, group.
/// R, G and B are sRGB, 0 to 255, or with a decimal point 0 to 1. Value 0, the background, is left out.
/// Throws InputError naming the file, the line or JSON path, what was expected and found.
std::vector<LabelName> readLabelNames(const std::filesystem::path& file);

/// The structures of TotalSegmentator 2: values 1 to 117, ascending. Behind them those that version 1 alone
/// has, without values, because its values mean others.
const std::vector<LabelName>& totalSegmentatorNames();

/// Gives labels the names, groups and colours that the list has: by value, or where an entry has no value by
/// name in any case. What an entry leaves open stays.
void applyNames(LabelTable& table, std::span<const LabelName> names);
/// Gives groups and colours to labels that lack them and have the name of a structure that ships with the
/// program, in any case.
void applyKnownNames(LabelTable& table);

/// A colour for a label without one: always the same for a value, unlike those of the values near it. Linear
/// light, [0,1], Rec. 709 primaries.
glm::vec3 labelColour(std::uint32_t value);

/// True if a label is meant by a pattern: its name, its value ("7"), or "group:NAME". In names * stands for
/// any characters and ? for one; case does not matter.
bool labelMatches(const Label& label, std::string_view pattern);

/// Finds the labels that patterns mean. Where a pattern is a whole number, it looks at few of them.
class LabelMatcher {
  public:
    /// @param labels  ascending by value; outlive this
    explicit LabelMatcher(std::span<const Label> labels);
    /// Calls visit(number) once for every label that matches (labelMatches()). Returns whether any does.
    template <typename Visit> bool forEach(std::string_view pattern, const Visit& visit) const {
        bool any = false;
        const auto look = [&](std::size_t number) {
            if (!labelMatches(labels_[number], pattern))
                return;
            any = true;
            visit(number);
        };
        const std::size_t valued = numberOfValue(pattern);
        if (valued == kNoNumber) {
            for (std::size_t number = 0; number < labels_.size(); ++number)
                look(number);
            return any;
        }
        for (const std::size_t number : namedByNumbers_)
            if (number != valued)
                look(number);
        if (valued < labels_.size())
            look(valued);
        return any;
    }

  private:
    static constexpr std::size_t kNoNumber = ~std::size_t{0};
    /// The label of a value; labels_.size(): none has it; kNoNumber: the pattern is no whole number.
    std::size_t numberOfValue(std::string_view pattern) const;

    std::span<const Label> labels_;
    std::vector<std::size_t> namedByNumbers_; // labels whose names are whole numbers
};

/// For a pattern that matches no label: at most `most` names (or "group:NAME") that are nearest to it, the
/// nearest first.
std::vector<std::string> nearestNames(const LabelTable& table, std::string_view pattern,
                                      std::size_t most = 3);

} // namespace tessera

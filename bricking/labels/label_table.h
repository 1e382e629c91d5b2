// bricking/labels/label_table.h: LabelTable: the labels of a segmentation, and the sets of them that voxels
// have. A voxel of a label volume holds the number of a set, so labels may overlap and have any 32-bit value.
#pragma once

#include "core/base/volume.h"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

struct Label {
    std::uint32_t value = 0;              // in its file; never 0, which is no label
    std::string name;                     // UTF-8; never empty: "label 7" where the file has none
    std::string group = {};               // "" none
    std::optional<glm::vec3> colour = {}; // linear light, [0,1], Rec. 709 primaries; none: by labelColour()
    bool operator==(const Label&) const = default;
};

struct LabelTable {
    static constexpr std::size_t kMostSets = 65535;
    std::vector<Label> labels; // ascending by value, no value twice
    /// Of every set the numbers of its labels, ascending; sets by comesBefore(), none twice. The first set is
    /// empty: no label.
    std::vector<std::vector<std::uint16_t>> sets{{}};
    bool operator==(const LabelTable&) const = default;
};

/// Memory that it takes, roughly.
inline std::size_t bytesOf(const LabelTable& table) {
    constexpr std::size_t kAllocation = 32; // of the heap, for a text or a list
    std::size_t bytes = 0;
    for (const Label& label : table.labels)
        bytes += sizeof(Label) + label.name.size() + label.group.size() + kAllocation;
    using Set = std::vector<std::uint16_t>;
    for (const Set& set : table.sets)
        bytes += sizeof(Set) + set.size() * sizeof(std::uint16_t) + kAllocation;
    return bytes;
}

/// The order of sets: by their size, then by their first labels that differ.
inline bool comesBefore(const std::vector<std::uint16_t>& a, const std::vector<std::uint16_t>& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
}

/// The type of a volume with the numbers of its sets: u8 for less than 256 sets, else u16.
inline ValueType labelTypeOf(const LabelTable& table) {
    return table.sets.size() < 256 ? ValueType::u8 : ValueType::u16;
}

} // namespace tessera

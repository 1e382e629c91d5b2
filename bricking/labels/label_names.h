// bricking/labels/label_names.h: stub.
#pragma once
#include "bricking/labels/label_table.h"
#include <string_view>
namespace tessera {
inline bool labelMatches(const Label& label, std::string_view pattern) {
    return label.name == pattern;
}
inline std::string nearestLabels(const LabelTable&, const std::string&) {
    return "?";
}
inline glm::vec3 labelColour(std::uint32_t) {
    return glm::vec3(0.8f, 0.4f, 0.2f);
}
} // namespace tessera

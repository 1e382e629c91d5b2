// bricking/import/labels/zarr/ome_labels.cpp: see ome_labels.h.
#include "bricking/import/labels/zarr/ome_labels.h"

#include "bricking/import/zarr/ome_image.h"
#include "core/base/shown_text.h"
#include "core/image/colour.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <set>

namespace tessera {
namespace {

std::uint32_t labelValueOf(const JsonValue& row, std::set<std::uint32_t>& seen) {
    constexpr double kMost = 4294967295.0;
    const JsonValue value = row.at("label-value");
    const double number = value.number(0, kMost);
    if (number != std::floor(number))
        value.refuse("a whole number");
    const auto label = static_cast<std::uint32_t>(number);
    if (!seen.insert(label).second)
        value.refuse("every label once");
    return label;
}

std::string nameOf(const JsonValue& row) {
    constexpr std::size_t kMostNames = 1000;
    for (const char* key : {"name", "names", "label", "class"}) {
        if (!row.has(key))
            continue;
        const JsonValue value = row.at(key);
        if (value.isText())
            return value.text();
        std::string all;
        if (value.isList())
            for (const JsonValue item : value.items(kMostNames, "names"))
                if (item.isText())
                    all += (all.empty() ? "" : ", ") + item.text();
        if (!all.empty())
            return all;
    }
    return "";
}

glm::vec3 colourOf(const JsonValue& list) {
    glm::vec3 colour{0};
    constexpr int kParts = 4;
    constexpr double kMost = 255;
    const JsonItems parts = list.items(kParts, "parts of a colour");
    if (parts.size() != kParts)
        list.refuse("four numbers from 0 to 255");
    for (int i = 0; i < kParts; ++i) {
        const double part = parts[static_cast<std::size_t>(i)].number(0, kMost);
        if (i < 3)
            colour[i] = static_cast<float>(linearFromSrgb(part / kMost));
    }
    return colour;
}

} // namespace

OmeLabels omeLabelsOf(const ZarrNode& group) {
    OmeLabels out;
    const auto ome = omeAttributesOf(group);
    if (!ome || !ome->has("image-label"))
        return out;
    out.isThere = true;
    const JsonValue about = ome->at("image-label");
    if (!about.isObject())
        about.refuse("an object");
    std::map<std::uint32_t, Label> labels;
    std::set<std::uint32_t> coloured, described;
    if (about.has("colors"))
        for (const JsonValue row : about.at("colors").items(LabelTable::kMostSets, "colours")) {
            const std::uint32_t value = labelValueOf(row, coloured);
            if (row.has("rgba"))
                labels[value].colour = colourOf(row.at("rgba"));
        }
    if (about.has("properties"))
        for (const JsonValue row : about.at("properties").items(LabelTable::kMostSets, "properties")) {
            const std::uint32_t value = labelValueOf(row, described);
            labels[value].name = printable(nameOf(row));
        }
    labels.erase(0);
    for (auto& [value, label] : labels) {
        label.value = value;
        if (label.name.empty())
            label.name = "label " + std::to_string(value);
        out.labels.push_back(std::move(label));
    }
    if (about.has("source") && about.at("source").isObject() && about.at("source").has("image"))
        out.image = about.at("source").at("image").text();
    return out;
}

} // namespace tessera

// bricking/labels/label_names_json.cpp: see label_names_text.h.
#include "bricking/labels/label_names_text.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/base/shown_text.h"
#include "core/image/colour.h"

#include <limits>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

constexpr double kMostValue = std::numeric_limits<std::uint32_t>::max();

std::uint32_t valueOf(const JsonValue& json) {
    const double value = json.number(0, kMostValue);
    if (value != static_cast<double>(static_cast<std::uint32_t>(value)))
        json.refuse("a whole number");
    return static_cast<std::uint32_t>(value);
}

glm::vec3 colourOf(const JsonValue& json) {
    if (json.isList()) {
        glm::vec3 colour{0};
        const std::vector<double> parts = json.numbers(3);
        for (std::size_t i = 0; i < 3; ++i) {
            if (!(parts[i] >= 0 && parts[i] <= 255))
                json.refuse("three numbers from 0 to 255");
            colour[static_cast<int>(i)] = static_cast<float>(linearFromSrgb(parts[i] / 255));
        }
        return colour;
    }
    const std::optional<glm::vec3> colour = findColour(json.text());
    if (!colour)
        json.refuse("a colour, #rrggbb or a name (nearest: \"" + nearestColour(json.text()) + "\")");
    return *colour;
}

/// The fields of an object; its name may come from outside.
LabelName fromObject(const JsonValue& json, const std::string& name) {
    json.requireKeys({"value", "name", "colour", "color", "group"});
    LabelName out;
    if (json.has("value"))
        out.value = valueOf(json.at("value"));
    out.name = json.has("name") ? printable(json.at("name").text()) : printable(name);
    if (json.has("group"))
        out.group = printable(json.at("group").text());
    for (const char* key : {"colour", "color"})
        if (json.has(key))
            out.colour = colourOf(json.at(key));
    if (out.name.empty() && !out.value)
        json.refuse("a value or a name");
    return out;
}

} // namespace

std::vector<LabelName> labelNamesOfJson(const std::string& text, const std::string& where) {
    const nlohmann::json document = parseStrictJson(text, where);
    const JsonValue root(document, where);
    std::vector<LabelName> names;
    if (root.isList()) {
        for (const JsonValue item : root.items())
            names.push_back(fromObject(item, ""));
    } else if (root.isObject()) {
        for (const auto& [key, ignored] : document.items()) {
            const JsonValue value = root.at(key);
            if (value.isObject())
                names.push_back(fromObject(value, key));
            else if (ignored.is_number())
                names.push_back({valueOf(value), printable(key)});
            else
                names.push_back({{}, printable(key), "", colourOf(value)});
        }
    } else {
        root.refuse("an object of names, or a list of objects");
    }
    return names;
}

} // namespace tessera

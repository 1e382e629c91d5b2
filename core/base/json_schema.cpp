// core/base/json_schema.cpp: see json_schema.h.
#include "core/base/json_schema.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tessera {
namespace {

constexpr std::size_t kSchemaColumns = 110;

/// On one line.
std::string lineOf(const Schema& schema) {
    constexpr double kWhole = 1e15;
    if (schema.is_number_float() && std::abs(schema.get<double>()) < kWhole &&
        schema.get<double>() == std::floor(schema.get<double>()))
        return std::to_string(schema.get<std::int64_t>()); // 10000 rather than 10000.0
    if (!schema.is_structured())
        return schema.dump();
    std::string all;
    for (const auto& [key, value] : schema.items())
        all +=
            (all.empty() ? "" : ", ") + (schema.is_object() ? Schema(key).dump() + ": " : "") + lineOf(value);
    return schema.is_object() ? "{" + all + "}" : "[" + all + "]";
}

void print(const Schema& schema, std::size_t indent, std::size_t before, std::string& out) {
    const std::string line = lineOf(schema);
    if (!schema.is_structured() || before + line.size() <= kSchemaColumns) {
        out += line;
        return;
    }
    out += schema.is_object() ? "{" : "[";
    const char* comma = "";
    for (const auto& [key, value] : schema.items()) {
        const std::string name = schema.is_object() ? Schema(key).dump() + ": " : "";
        out += comma + ("\n" + std::string(indent + 2, ' ')) + name;
        print(value, indent + 2, indent + 2 + name.size() + 1, out);
        comma = ",";
    }
    out += "\n" + std::string(indent, ' ') + (schema.is_object() ? "}" : "]");
}

const Schema& resolved(const Schema& schema, const Schema& document) {
    if (!schema.contains("$ref"))
        return schema;
    return document.at(Schema::json_pointer(schema["$ref"].get<std::string>().substr(1)));
}

/// "number", "number, 0 to 1", "whole number from 1".
std::string numberKind(const Schema& schema, const std::string& plural) {
    const bool isWhole = schema.value("type", "") == "integer";
    const std::string what = (isWhole ? "whole number" : "number") + plural;
    const bool hasEnd = schema.contains("maximum") && schema["maximum"] != std::numeric_limits<int>::max();
    if (schema.contains("minimum") && hasEnd)
        return what + ", " + lineOf(schema["minimum"]) + " to " + lineOf(schema["maximum"]);
    if (schema.contains("exclusiveMinimum"))
        return what + " above " + lineOf(schema["exclusiveMinimum"]);
    return schema.contains("minimum") ? what + " from " + lineOf(schema["minimum"]) : what;
}

/// The allowed values, for people: "0 to 1", "`axial`, `coronal`".
std::string valueText(const Schema& given, const Schema& document) {
    const Schema& schema = resolved(given, document);
    for (const char* choice : {"oneOf", "anyOf"})
        if (schema.contains(choice)) {
            std::string all;
            for (const Schema& one : schema[choice])
                if (!resolved(one, document).contains("properties"))
                    all += (all.empty() ? "" : " or ") + valueText(one, document);
            return all;
        }
    if (schema.contains("const"))
        return "`" + schema["const"].dump() + "`";
    if (schema.contains("enum")) {
        std::string all;
        for (const Schema& one : schema["enum"])
            all += (all.empty() ? "`" : ", `") +
                   (one == ""         ? "\"\""
                    : one.is_string() ? one.get<std::string>()
                                      : one.dump()) +
                   "`";
        return all;
    }
    const std::string type = schema.value("type", "");
    if (type == "boolean")
        return "`true`, `false`";
    if (type == "string")
        return "text";
    if (type != "array")
        return numberKind(schema, "");
    const Schema& items = resolved(schema["items"], document);
    const std::string what = items.value("type", "");
    const std::size_t least = schema.value("minItems", 0U), most = schema.value("maxItems", 0U);
    if ((what == "number" || what == "integer") && least > 0 && least == most)
        return std::to_string(most) + " " + numberKind(items, "s");
    return "list of " + valueText(items, document) + (most > 0 ? ", at most " + std::to_string(most) : "");
}

/// The names that a value may be, beside other values or alone.
std::vector<std::string> namesIn(const Schema& given, const Schema& document) {
    const Schema& schema = resolved(given, document);
    if (schema.contains("enum") && schema["enum"][0].is_string())
        return schema["enum"].get<std::vector<std::string>>();
    if (schema.contains("oneOf"))
        for (const Schema& one : schema["oneOf"])
            if (std::vector<std::string> names = namesIn(one, document); !names.empty())
                return names;
    return {};
}

/// Removes the options of a schema and of all that it holds.
void removeOptions(Schema& schema) {
    if (schema.is_object())
        schema.erase(kOptionKey);
    for (Schema& part : schema)
        if (part.is_structured())
            removeOptions(part);
}

void collectKeys(const Schema& given, const Schema& document, const std::string& path,
                 std::vector<KeyRow>& rows);

/// Keys of the objects that may stand there.
void collectBelow(const Schema& given, const Schema& document, const std::string& path,
                  std::vector<KeyRow>& rows) {
    const Schema& schema = resolved(given, document);
    if (schema.contains("properties"))
        collectKeys(schema, document, path, rows);
    else if (schema.contains("items"))
        collectBelow(schema["items"], document, path + "[]", rows);
    else if (schema.contains("oneOf"))
        for (const Schema& one : schema["oneOf"])
            collectBelow(one, document, path, rows);
}

void collectKeys(const Schema& schema, const Schema& document, const std::string& path,
                 std::vector<KeyRow>& rows) {
    for (const auto& [key, value] : schema["properties"].items()) {
        const std::string place = path.empty() ? key : path + "." + key;
        const std::size_t before = rows.size();
        collectBelow(value, document, place, rows);
        const std::string said = valueText(value, document);
        const bool holdsKeysAlone = rows.size() > before && !value.contains("oneOf");
        const bool isThere =
            std::any_of(rows.begin(), rows.end(), [&](const KeyRow& row) { return row.path == place; });
        if (holdsKeysAlone || said.empty() || isThere)
            continue;
        KeyRow row{place,
                   said,
                   value.contains("default") ? lineOf(value["default"]) : "",
                   value.value("description", ""),
                   namesIn(value, document),
                   resolved(value, document),
                   {}};
        if (value.contains(kOptionKey))
            row.option = {value[kOptionKey][0], value[kOptionKey][1], value[kOptionKey][2]};
        rows.insert(rows.begin() + static_cast<std::ptrdiff_t>(before), std::move(row));
    }
}

} // namespace

Schema documentSchema(const std::string& title, const std::string& about, Schema root, Schema parts) {
    Schema schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                     {"title", title},
                     {"description", about}};
    schema.update(root);
    schema["$defs"] = std::move(parts);
    return schema;
}

std::string schemaText(const Schema& schema) {
    Schema published = schema;
    removeOptions(published);
    std::string text;
    print(published, 0, 0, text);
    return text + "\n";
}

std::vector<KeyRow> keysOf(const Schema& document) {
    std::vector<KeyRow> rows;
    collectKeys(document, document, "", rows);
    return rows;
}

std::string keyTable(const std::vector<KeyRow>& keys) {
    std::string text = "| key | option | value | default | meaning |\n|---|---|---|---|---|\n";
    for (const KeyRow& row : keys) {
        std::string about;
        for (const char c : row.about)
            about += c == '|' || c == '*' ? std::string("\\") + c : std::string(1, c);
        const std::string option = row.option.name.empty() ? "" : "`" + row.option.name + "`";
        text += "| `" + row.path + "` | " + option + " | " + row.value + " | " +
                (row.preset.empty() ? "" : "`" + row.preset + "`") + " | " + about + " |\n";
    }
    return text;
}

} // namespace tessera

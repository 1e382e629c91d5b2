// tests/support/every_scene_key.h: scenes that have every key, made from the table of keys. A new key is in
// them at once, unless it is only read beside another.
#pragma once

#include "core/base/error.h"
#include "core/scene/scene_fields.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tessera::test {

using nlohmann::json;

inline const json& resolvedIn(const json& root, const json& schema) {
    return schema.contains("$ref") ? root.at(json::json_pointer(schema["$ref"].get<std::string>().substr(1)))
                                   : schema;
}

/// Adds to a document all keys that are missing, each with a value unlike its default.
class KeyFiller {
  public:
    /// @param schema  must outlive it
    /// @param last  where a value may be of several kinds, the last one is taken rather than the first
    KeyFiller(json document, const json& schema, bool last)
        : document_(std::move(document)), root_(schema), last_(last) {}

    json filled() {
        for (int pass = 0; pass < 2; ++pass) // a key may need one that is added behind it
            fill(json::json_pointer(), root_);
        return document_;
    }

  private:
    const json& kindOf(const json& given) const {
        const json& schema = resolvedIn(root_, given);
        for (const char* choice : {"oneOf", "anyOf"})
            if (schema.contains(choice) && !schema.contains("properties"))
                return kindOf(last_ ? schema[choice].back() : schema[choice].front());
        return schema;
    }

    bool isRead() const {
        try {
            parseScene(document_.dump(), "/", "s.json");
            return true;
        } catch (const InputError&) {
            return false;
        }
    }

    void fill(const json::json_pointer& place, const json& given) {
        const json& schema = kindOf(given);
        if (schema.contains("items") && kindOf(schema["items"]).contains("properties"))
            for (std::size_t i = 0; i < document_[place].size(); ++i)
                fill(place / i, schema["items"]);
        if (!schema.contains("properties"))
            return;
        for (const auto& [key, property] : schema["properties"].items()) {
            if (const json before = document_; !document_.contains(place / key)) {
                document_[place / key] = valueOf(property);
                if (!isRead()) {
                    document_ = before;
                    continue;
                }
            }
            fill(place / key, property);
        }
    }

    /// A value that the schema accepts: of an object the least. Numbers ascend, and stay within [0,1] where
    /// they may, because some are clamped to it.
    json valueOf(const json& property) {
        const json& schema = kindOf(property);
        const json preset = property.value("default", json());
        const std::string type = schema.value("type", "");
        if (schema.contains("const"))
            return schema["const"];
        if (schema.contains("enum"))
            return schema["enum"].back() != preset ? schema["enum"].back() : schema["enum"].front();
        if (type == "boolean")
            return preset != true;
        if (type == "integer") {
            const int lowest = schema.value("minimum", 0), highest = schema.value("maximum", kFar);
            const int value = wholeIn(lowest, highest);
            return value != preset ? value : wholeIn(lowest, highest);
        }
        if (type == "number")
            return std::max(schema.value("minimum", 0.0), 0.0) + ++count_ / 1024.0;
        if (type == "array")
            return listOf(schema["items"], std::max(schema.value("minItems", 0), 1));
        if (type == "object")
            return leastOf(schema);
        return "red";
    }
    int wholeIn(int lowest, int highest) { return lowest + 1 + count_++ % std::min(5, highest - lowest); }
    json listOf(const json& items, int size) {
        json list = json::array();
        while (size-- > 0)
            list.push_back(valueOf(items));
        return list;
    }
    json leastOf(const json& schema) {
        json object = json::object(), needed = schema.value("required", json::array());
        if (schema.contains("anyOf")) // of sets of keys
            needed = schema["anyOf"].front()["required"];
        for (const json& key : needed)
            object[key.get<std::string>()] = valueOf(schema["properties"][key.get<std::string>()]);
        return object;
    }

    static constexpr int kFar = 1 << 20;

    json document_;
    const json& root_;
    bool last_;
    int count_ = 0;
};

/// Documents that have every key between them; paths are absolute.
/// @param schema  sceneSchema()
inline std::vector<json> everySceneKey(const json& schema) {
    const char* const fitted =
        R"({"tesseraScene":1,"volumes":[{"path":"/a/x.zarr","labels":{"path":"/a/l.nrrd","names":"/a/l.csv"},
        "transform":[1,0,0,4,0,1,0,5,0,0,1,6]}],"image":{"background":"#336699"},
        "annotations":{"marginColour":"#996633"},
        "lighting":{"lights":[{"kind":"head"},{"kind":"directional"},{"kind":"point"}],
        "transport":{"response":"physical"},"environment":{"file":"/a/sky.exr"}},
        "meshes":[{"path":"/a/m.ply"}],
        "measurements":[{"kind":"distance","points":[[0,0,0],[1,2,2]]}]})";
    const char* const free =
        R"({"tesseraScene":1,"volumes":[{"path":"/a/x.zarr","labels":{"path":"/a/l.nrrd","names":"/a/l.csv"}}],
        "annotations":{"marginColour":"#996633"},
        "lighting":{"transport":{"response":"physical"},"environment":{"file":"/a/sky.exr"}},
        "meshes":[{"tube":{"points":[[1,2,3.5]],"radius":2}}],
        "slice":{"plane":"oblique","point":[1,2,3.5],"normal":[0,1,1]}})";
    return {KeyFiller(json::parse(fitted), schema, false).filled(),
            KeyFiller(json::parse(free), schema, true).filled()};
}

} // namespace tessera::test

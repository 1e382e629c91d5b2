// tests/core/scene/scene_fields_test.cpp: properties of every key of the table. It reads back, a refusal
// names its place, a missing key means its default, and it is published as it is read.
#include "core/scene/scene_fields.h"

#include "core/base/error.h"
#include "tests/support/every_scene_key.h"

#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <regex>

namespace tessera {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// The refusal of a value; "" if it is read.
std::string refusalOf(const json& document) {
    try {
        parseScene(document.dump(), "/", "s.json");
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

/// "$.volumes[0].path" of "/volumes/0/path".
std::string placeOf(const std::string& pointer) {
    std::string place = std::regex_replace(pointer, std::regex("/([0-9]+)"), "[$1]");
    return "$" + std::regex_replace(place, std::regex("/"), ".");
}

const json& resolved(const json& schema, const json& root) {
    return test::resolvedIn(root, schema);
}

/// True if the part of JSON Schema that ours uses accepts a value.
bool accepts(const json& given, const json& root, const json& value) {
    const json& schema = resolved(given, root);
    const auto any = [&](const char* key) {
        return std::any_of(schema[key].begin(), schema[key].end(),
                           [&](const json& one) { return accepts(one, root, value); });
    };
    if ((schema.contains("oneOf") && !any("oneOf")) || (schema.contains("anyOf") && !any("anyOf")))
        return false;
    if (schema.contains("const") && schema["const"] != value)
        return false;
    if (schema.contains("enum") &&
        std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
        return false;
    if (const std::string type = schema.value("type", "");
        (type == "object" && !value.is_object()) || (type == "array" && !value.is_array()) ||
        (type == "string" && !value.is_string()) || (type == "boolean" && !value.is_boolean()) ||
        (type == "number" && !value.is_number()) || (type == "integer" && !value.is_number_integer()))
        return false;
    if (value.is_number() && ((schema.contains("minimum") && value < schema["minimum"]) ||
                              (schema.contains("maximum") && value > schema["maximum"]) ||
                              (schema.contains("exclusiveMinimum") && value <= schema["exclusiveMinimum"]) ||
                              (schema.contains("exclusiveMaximum") && value >= schema["exclusiveMaximum"])))
        return false;
    if (value.is_array() && schema.contains("items")) {
        if (value.size() < schema.value("minItems", std::size_t{0}) ||
            value.size() > schema.value("maxItems", value.size()))
            return false;
        for (const json& item : value)
            if (!accepts(schema["items"], root, item))
                return false;
    }
    if (value.is_object()) {
        for (const json& key : schema.value("required", json::array()))
            if (!value.contains(key.get<std::string>()))
                return false;
        for (const auto& [key, item] : value.items())
            if (schema.contains("properties") &&
                (!schema["properties"].contains(key) || !accepts(schema["properties"][key], root, item)))
                return false;
    }
    return true;
}

/// A value of a document, and what is published of it.
struct Place {
    json document;
    std::string pointer;
    json schema; // resolved; of alternatives the one that accepts what is there
};

void collect(const json& document, const json& value, const std::string& pointer, const json& given,
             const json& root, std::vector<Place>& places) {
    json schema = resolved(given, root);
    for (const char* choice : {"oneOf", "anyOf"})
        if (schema.contains(choice) && !schema.contains("properties"))
            for (const json& one : json(schema[choice]))
                if (accepts(one, root, value))
                    schema = resolved(one, root);
    places.push_back({document, pointer, schema});
    if (value.is_object())
        for (const auto& [key, item] : value.items())
            collect(document, item, pointer + "/" + key, schema["properties"][key], root, places);
    if (value.is_array())
        for (std::size_t i = 0; i < value.size(); ++i)
            collect(document, value[i], pointer + "/" + std::to_string(i), schema["items"], root, places);
}

const json& published() {
    static const json schema = sceneSchema();
    return schema;
}
const std::vector<json>& documents() {
    static const std::vector<json> all = test::everySceneKey(published());
    return all;
}
const std::vector<Place>& everyPlace() {
    static const std::vector<Place> places = [] {
        std::vector<Place> all;
        for (const json& document : documents())
            collect(document, document, "", published(), published(), all);
        return all;
    }();
    return places;
}
json with(const Place& place, const json& value) {
    json document = place.document;
    document[json::json_pointer(place.pointer)] = value;
    return document;
}
const json& valueOf(const Place& place) {
    return place.document.at(json::json_pointer(place.pointer));
}

TEST(SceneFields, BothDocumentsHaveEveryKeyAndTheSchemaAcceptsThem) {
    std::set<std::string> shown, known;
    for (const Place& place : everyPlace())
        shown.insert(std::regex_replace(placeOf(place.pointer), std::regex("\\[[0-9]+\\]"), "[]"));
    for (const KeyRow& row : keysOf(sceneSchema())) {
        known.insert("$." + row.path);
        EXPECT_TRUE(shown.contains("$." + row.path)) << row.path << ": in neither of the documents";
        EXPECT_FALSE(row.about.empty()) << row.path << " says nothing of itself";
    }
    EXPECT_GT(known.size(), 100u);
    for (const json& document : documents())
        EXPECT_TRUE(accepts(published(), published(), document)) << document;
}

// What is written has every key that was read, with its value.
TEST(SceneFields, WhatIsReadIsWritten) {
    for (const Place& place : everyPlace()) {
        const json written = json::parse(sceneJson(parseScene(place.document.dump(), "/", "s.json")));
        const json::json_pointer pointer(place.pointer);
        ASSERT_TRUE(written.contains(pointer)) << place.pointer;
        if (!valueOf(place).is_structured()) {
            EXPECT_EQ(written[pointer], valueOf(place)) << place.pointer;
        }
    }
}

TEST(SceneFields, AValueOfAnotherTypeIsRefusedByItsPlace) {
    for (const Place& place : everyPlace()) {
        const json& value = valueOf(place);
        const json other = value.is_boolean() || value.is_number() ? json("no such word") : json(7.5);
        EXPECT_THAT(refusalOf(with(place, other)), HasSubstr(placeOf(place.pointer) + ":")) << place.pointer;
    }
}

TEST(SceneFields, ANumberOutOfRangeIsRefusedByItsPlace) {
    int bounds = 0;
    for (const Place& place : everyPlace()) {
        const auto refused = [&](const char* bound, double away) {
            if (!place.schema.contains(bound) || !place.schema[bound].is_number())
                return;
            const double edge = place.schema[bound].get<double>(),
                         beyond = edge + away * (1 + std::abs(edge));
            const json value =
                place.schema.value("type", "") == "integer" ? json(std::llround(beyond)) : json(beyond);
            EXPECT_NE(refusalOf(with(place, value)), "") << place.pointer << " " << value;
            ++bounds;
        };
        refused("minimum", -1);
        refused("exclusiveMinimum", -1);
        refused("maximum", 1);
        refused("exclusiveMaximum", 1);
    }
    EXPECT_GT(bounds, 60);
}

TEST(SceneFields, AMisspeltKeyIsRefusedByItsPlaceWithTheRightOne) {
    for (const Place& place : everyPlace()) {
        if (!valueOf(place).is_object())
            continue;
        for (const auto& [key, unused] : valueOf(place).items()) {
            const std::string wrong = key + "x";
            json object = valueOf(place);
            object[wrong] = 1;
            const json document = place.pointer.empty() ? object : with(place, object);
            EXPECT_EQ(refusalOf(document), "s.json: " + placeOf(place.pointer) +
                                               ": expected a known key, found \"" + wrong +
                                               "\"; nearest: \"" + key + "\"");
        }
    }
}

// A default that is published is what files without the key mean.
TEST(SceneFields, WithoutAKeyItsDefaultIsMeant) {
    int defaults = 0;
    for (const Place& place : everyPlace()) {
        if (!valueOf(place).is_object())
            continue;
        for (const auto& [key, unused] : valueOf(place).items()) {
            const json& property = place.schema["properties"][key];
            if (!property.contains("default"))
                continue;
            json without = place.document, said = place.document;
            without[json::json_pointer(place.pointer)].erase(key);
            said[json::json_pointer(place.pointer + "/" + key)] = property["default"];
            if (refusalOf(without) != "" || refusalOf(said) != "")
                continue; // a companion needs it
            EXPECT_EQ(sceneJson(parseScene(without.dump(), "/", "s")),
                      sceneJson(parseScene(said.dump(), "/", "s")))
                << place.pointer << "/" << key;
            ++defaults;
        }
    }
    EXPECT_GT(defaults, 50);
}

// The schema accepts all that the reader accepts: of every place, values of all kinds.
TEST(SceneFields, TheSchemaAcceptsWhatIsRead) {
    const std::vector<json> values = {nullptr,
                                      true,
                                      -1,
                                      0,
                                      0.5,
                                      1,
                                      2.5,
                                      7,
                                      300,
                                      1e9,
                                      "",
                                      "auto",
                                      "left",
                                      "red",
                                      json::array(),
                                      json::object(),
                                      {1, 2},
                                      {0, 0.5, 1},
                                      {{1, 2}, {3, 4}}};
    int read = 0;
    for (const Place& place : everyPlace())
        for (const json& value : values)
            if (const json document = with(place, value); refusalOf(document).empty()) {
                EXPECT_TRUE(accepts(published(), published(), document)) << place.pointer << " " << value;
                ++read;
            }
    EXPECT_GT(read, 300);
}

Scene plainScene() {
    return parseScene(R"({"tesseraScene":1,"volumes":[{"path":"/v"}]})", "/", "s.json");
}
std::string setRefusal(const std::string& key, const json& value) {
    Scene scene = plainScene();
    const std::string before = sceneJson(scene);
    try {
        setSceneKey(scene, key, value, "--set");
    } catch (const InputError& error) {
        EXPECT_EQ(sceneJson(scene), before) << key << ": what is refused changes nothing";
        return error.what();
    }
    return {};
}

TEST(SceneFields, AKeyThatIsSetToWhatItIsChangesNothing) {
    for (const Place& place : everyPlace()) {
        if (place.pointer.empty() || place.pointer == "/volumes" || place.pointer == "/volumes/0" ||
            place.pointer == "/volumes/0/path")
            continue; // of a file, paths are taken from its folder
        Scene scene = parseScene(place.document.dump(), "/", "s.json");
        const std::string before = sceneJson(scene);
        ASSERT_NO_THROW(setSceneKey(scene, placeOf(place.pointer).substr(2), valueOf(place), "--set"))
            << place.pointer;
        EXPECT_EQ(json::parse(sceneJson(scene)), json::parse(before)) << place.pointer;
    }
}

TEST(SceneFields, AKeyIsSetAsAFileWouldSetIt) {
    for (const auto& [key, value, part] : std::vector<std::tuple<std::string, json, std::string>>{
             {"shading.ambient", 0.5, R"({"shading":{"ambient":0.5}})"},
             {"mode", "slice", R"({"mode":"slice"})"},
             {"window", {40, 400}, R"({"window":[40,400]})"},
             {"isosurfaces[0].value", 300, R"({"isosurfaces":[{"value":300}]})"},
             {"lighting.occlusion.rays", 64, R"({"lighting":{"occlusion":{"rays":64}}})"},
             {"quality.samples", "auto", R"({"quality":{"samples":"auto"}})"},
             {"quality.stepVoxels", 0.25, R"({"quality":{"stepVoxels":0.25}})"},
             {"image.background", "red", R"({"image":{"background":"red"}})"},
             {"volumes[0].transferFunction", "lung",
              R"({"volumes":[{"path":"/v","transferFunction":"lung"}]})"}}) {
        Scene scene = plainScene();
        setSceneKey(scene, key, value, "--set");
        json document = json::parse(R"({"tesseraScene":1,"volumes":[{"path":"/v"}]})");
        document.update(json::parse(part));
        EXPECT_EQ(sceneJson(scene), sceneJson(parseScene(document.dump(), "/", "s.json"))) << key;
    }
}

TEST(SceneFields, AKeyThatIsSetWronglyIsRefusedByTheOption) {
    EXPECT_EQ(setRefusal("shading.ambient", 2), "--set: expected a number from 0 to 1, found 2");
    EXPECT_EQ(setRefusal("quality.fetch", "exakt"),
              "--set: expected one of hardware, exact, found \"exakt\"; nearest: \"exact\"");
    EXPECT_EQ(setRefusal("shading.ambiet", 0.5),
              "--set: expected a known key, found \"ambiet\"; nearest: \"ambient\"");
    EXPECT_EQ(setRefusal("ambient", 0.5),
              "--set: expected a key of scenes, found \"ambient\"; nearest: \"shading.ambient\"");
    EXPECT_EQ(setRefusal("shading.ambient.x", 1), "--set: expected a number from 0 to 1, found an object");
    EXPECT_EQ(setRefusal("isosurfaces[1].value", 1), "--set: expected an item from 0 to 0, found [1]");
    for (const char* key : {"", ".", "[", "[]", "shading.", "shading..ambient", "isosurfaces[",
                            "isosurfaces[0", "isosurfaces[-1]", "isosurfaces[99999999999999999999].value",
                            "isosurfaces[0]value", "volumes[0].path.x"})
        EXPECT_NE(setRefusal(key, 1), "") << key;
    Scene scene = plainScene();
    setSceneKey(scene, "mode", "mip", "--set"); // a person's other word
    EXPECT_EQ(scene.mode, Mode::maximum);
    EXPECT_NE(refusalOf(json::parse(R"({"tesseraScene":1,"volumes":[{"path":"/v"}],"mode":"mip"})")), "");
}

} // namespace
} // namespace tessera

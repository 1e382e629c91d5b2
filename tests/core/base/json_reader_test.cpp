// tests/core/base/json_reader_test.cpp: what the strict reader of JSON takes and refuses: each limit is met
// exactly and exceeded by one, and messages name place, expected and found value.
#include "core/base/json_reader.h"

#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "tests/support/refusals.h"

#include <cmath>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>

namespace tessera {
namespace {

using test::refusalOf;

using nlohmann::json;

std::string nested(int levels) {
    const auto n = static_cast<std::size_t>(levels);
    return std::string(n, '[') + std::string(n, ']');
}

TEST(JsonReader, NestsAsDeepAsItSays) {
    EXPECT_EQ(parseStrictJson(nested(kMaxJsonDepth), "f"), json::parse(nested(kMaxJsonDepth)));
    EXPECT_EQ(refusalOf([] { parseStrictJson(nested(kMaxJsonDepth + 1), "f"); }),
              "f: expected at most 16 nested levels, found more");
    // closed levels do not count
    std::string siblings = "[[]";
    for (int i = 0; i < 40; ++i)
        siblings += ",{\"a\":[]}";
    EXPECT_EQ(parseStrictJson(siblings + "]", "f").size(), 41u);
}

TEST(JsonReader, KeysAreTakenOnceAnObject) {
    EXPECT_EQ(parseStrictJson(R"({"a":{"b":1},"b":[{"a":2},{"a":3}]})", "f")["b"][1]["a"], 3);
    EXPECT_EQ(refusalOf([] { parseStrictJson(R"({"b":{"a":1,"c":2,"a":3}})", "f"); }),
              "f: expected every key once in an object, found the key \"a\" twice");
}

TEST(JsonReader, FaultsOfTheTextAreToldByLineAndColumn) {
    const std::string said = refusalOf([] { parseStrictJson("{\n\"a\": 1,,}", "f"); });
    EXPECT_EQ(said.rfind("f: expected JSON, found a parse error at line 2, column 8", 0), 0u) << said;
    EXPECT_EQ(said.find_first_of("\n\r"), std::string::npos) << said;
    EXPECT_EQ(said.find("json.exception"), std::string::npos) << said;
}

TEST(JsonReader, FilesAreReadUpToTheLimit) {
    const ScratchFolder folder;
    const auto write = [&](std::size_t bytes) {
        std::ofstream(folder / "f.json", std::ios::binary) << std::string(bytes, ' ');
    };
    write(kMaxJsonBytes);
    EXPECT_EQ(readTextFile((folder / "f.json").string()).size(), kMaxJsonBytes);
    write(kMaxJsonBytes + 1);
    EXPECT_THAT(refusalOf([&] { readTextFile((folder / "f.json").string()); }),
                testing::EndsWith("f.json: expected at most 16 MiB of JSON, found 16777217 bytes"));
    EXPECT_NE(refusalOf([] { parseStrictJson(std::string(kMaxJsonBytes - 1, ' ') + "1", "f"); }),
              "f: expected at most 16 MiB of JSON, found more");
    EXPECT_EQ(refusalOf([] { parseStrictJson(std::string(kMaxJsonBytes, ' ') + "1", "f"); }),
              "f: expected at most 16 MiB of JSON, found more");
    write(0);
    EXPECT_EQ(readTextFile((folder / "f.json").string()), "");
    EXPECT_THAT(refusalOf([&] { readTextFile((folder / "g.json").string()); }),
                testing::EndsWith("g.json: expected a readable file, found none"));
}

/// A value at $.a[1].
struct There {
    explicit There(const json& value) : document({{"a", {0, value}}}) {}
    JsonValue value() const { return JsonValue(document, "f").at("a").items()[1]; }
    json document;
};

TEST(JsonReader, ValuesOfOtherKindsAreRefusedAtTheirPlace) {
    struct Row {
        std::function<void(const JsonValue&)> read;
        std::string expected;
        std::vector<json> taken, refused;
    };
    const std::vector<Row> rows = {
        {[](const JsonValue& v) { v.boolean(); }, "true or false", {true, false}, {0, "true", nullptr}},
        {[](const JsonValue& v) { v.text(); }, "a text", {"", "a"}, {1, true, json::array()}},
        {[](const JsonValue& v) { v.number(); }, "a number", {0, -1.5, 1e300}, {"1", nullptr, true}},
        {[](const JsonValue& v) { v.number(-1, 2.5); },
         "a number from -1 to 2.5",
         {-1, 2.5, 0, 2},
         {std::nextafter(-1.0, -2.0), std::nextafter(2.5, 3.0), 3, "0"}},
        {[](const JsonValue& v) { v.integer(-2, 5); },
         "a whole number from -2 to 5",
         {-2, 5, 0},
         {-3, 6, 1.5, 2.0, 5000000000, "1"}},
        {[](const JsonValue& v) { v.numbers(2); },
         "a list of 2 numbers",
         {{1, 2.5}},
         {{1}, {1, 2, 3}, json::array(), 1, json::object()}},
        {[](const JsonValue& v) { v.items(2, "things"); },
         "at most 2 things",
         {json::array(), {1}, {1, 2}},
         {{1, 2, 3}}},
        {[](const JsonValue& v) { v.items(); }, "a list", {json::array(), {"a"}}, {1, json::object(), "[]"}},
        {[](const JsonValue& v) { v.at("k"); }, "an object", {{{"k", 1}}}, {1, "k", json::array()}},
        {[](const JsonValue& v) { v.requireKeys({"k"}); },
         "an object",
         {json::object(), {{"k", 1}}},
         {1, json::array()}},
        {[](const JsonValue& v) {
             v.oneOf({"one", "two"});
         },
         "one of one, two",
         {"one", "two"},
         {1, nullptr}},
    };
    for (const Row& row : rows) {
        for (const json& good : row.taken)
            EXPECT_EQ(refusalOf([&] { row.read(There(good).value()); }), "no refusal")
                << row.expected << good;
        for (const json& bad : row.refused) {
            const std::string found = bad.is_object()  ? "an object"
                                      : bad.is_array() ? "a list of " + std::to_string(bad.size())
                                                       : bad.dump();
            EXPECT_EQ(refusalOf([&] { row.read(There(bad).value()); }),
                      "f: $.a[1]: expected " + row.expected + ", found " + found);
        }
    }
    EXPECT_EQ(refusalOf([] {
                  There({1, "x"}).value().numbers(2);
              }),
              "f: $.a[1][1]: expected a number, found \"x\"");
    EXPECT_EQ(refusalOf([] {
                  There(json{{"kay", 1}}).value().requireKeys({"key", "other"});
              }),
              "f: $.a[1]: expected a known key, found \"kay\"; nearest: \"key\"");
    EXPECT_EQ(refusalOf([] {
                  There(json{{"kay", 1}}).value().at("key");
              }),
              "f: $.a[1]: expected the key \"key\", found none");
    EXPECT_EQ(refusalOf([] {
                  There("too").value().oneOf({"one", "two"});
              }),
              "f: $.a[1]: expected one of one, two, found \"too\"; nearest: \"two\"");
    json infinite = {{"a", {0, 1}}};
    infinite["a"][1] = std::numeric_limits<double>::infinity();
    EXPECT_THAT(refusalOf([&] { JsonValue(infinite, "f").at("a").items()[1].number(); }),
                testing::HasSubstr("expected a finite number"));
}

TEST(JsonReader, ShowsAsMuchOfAValueAsFits) {
    const auto shown = [](std::size_t letters) {
        return refusalOf([&] { There(std::string(letters, 'x')).value().number(); });
    };
    // 40 characters with the quotes
    EXPECT_EQ(shown(38), "f: $.a[1]: expected a number, found \"" + std::string(38, 'x') + "\"");
    EXPECT_EQ(shown(39), "f: $.a[1]: expected a number, found \"" + std::string(39, 'x') + "...");
    EXPECT_EQ(refusalOf([] { There("\xc3\xa9\xff").value().number(); }),
              "f: $.a[1]: expected a number, found \"\\u00e9\\ufffd\"");
}

TEST(JsonReader, WhatIsTypedIsNamedByItsOptionAlone) {
    const json document = {1, {{"k", "x"}}};
    const JsonValue typed = JsonValue::typed(document, "--set a");
    EXPECT_TRUE(typed.isTyped());
    EXPECT_FALSE(JsonValue(document, "f").isTyped());
    EXPECT_EQ(typed.place(), "--set a");
    EXPECT_EQ(refusalOf([&] { typed.items()[1].at("k").number(); }),
              "--set a: expected a number, found \"x\"");
}

TEST(JsonReader, ListsAreWalkedInTheirOrder) {
    const json document = {3, 1, 4, 1, 5};
    std::vector<double> seen;
    for (const JsonValue& item : JsonValue(document, "f").items())
        seen.push_back(item.number());
    EXPECT_EQ(seen, (std::vector<double>{3, 1, 4, 1, 5}));
    const JsonItems items = JsonValue(document, "f").items();
    EXPECT_EQ(items.size(), 5u);
    EXPECT_FALSE(items.empty());
    EXPECT_EQ(items.front().number(), 3);
    EXPECT_EQ(items[4].place(), "f: $[4]");
    EXPECT_TRUE(JsonItems(JsonValue(document, "f"), 0).empty());
}

TEST(JsonReader, AMissingKeyLeavesWhatIsThere) {
    const json document = {{"n", 2.5}, {"b", true}};
    const JsonValue whole(document, "f");
    double number = 7;
    bool flag = false;
    whole.read("m", 0, 1, number);
    whole.read("c", flag);
    EXPECT_EQ(number, 7);
    EXPECT_FALSE(flag);
    whole.read("n", 0, 3, number);
    whole.read("b", flag);
    EXPECT_EQ(number, 2.5);
    EXPECT_TRUE(flag);
    EXPECT_THROW(whole.read("n", 0, 2, number), InputError);
    EXPECT_TRUE(whole.has("n"));
    EXPECT_FALSE(whole.has("m"));
    EXPECT_FALSE(whole.at("n").has("n"));
    EXPECT_TRUE(whole.isObject() && !whole.isList() && !whole.isText());
}

} // namespace
} // namespace tessera

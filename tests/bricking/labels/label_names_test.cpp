// tests/bricking/labels/label_names_test.cpp: tables of names and colours in every format; the shipped table;
// colours by number; patterns.
#include "bricking/labels/label_names.h"
#include "core/image/colour.h"
#include "tests/support/label_file_tools.h"
#include "tests/support/recorded_numbers.h"

#include <glm/geometric.hpp>
#include <set>

namespace tessera::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

glm::vec3 srgb(int r, int g, int b) {
    return {linearFromSrgb(r / 255.0), linearFromSrgb(g / 255.0), linearFromSrgb(b / 255.0)};
}

void expectNames(const std::vector<LabelName>& found, const std::vector<LabelName>& expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].value, expected[i].value) << i;
        EXPECT_EQ(found[i].name, expected[i].name);
        EXPECT_EQ(found[i].group, expected[i].group);
        ASSERT_EQ(found[i].colour.has_value(), expected[i].colour.has_value()) << i;
        if (found[i].colour) {
            EXPECT_LT(glm::length(*found[i].colour - *expected[i].colour), 1e-6f) << i;
        }
    }
}

class LabelNames : public testing::Test {
  protected:
    std::vector<LabelName> read(const std::string& name, const std::string& text) {
        writeBytes(folder_ / name, text);
        return readLabelNames(folder_ / name);
    }
    std::string refusal(const std::string& name, const std::string& text) {
        try {
            read(name, text);
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr(name));
            return error.what();
        }
        return "";
    }
    std::filesystem::path folder_ = labelTestFolder();
};

TEST_F(LabelNames, ColourTablesOfSlicerAndFreeSurfer) {
    const std::vector<LabelName> expected = {{1u, "tissue", "", srgb(128, 174, 128)},
                                             {2u, "bone of the hip", "", srgb(241, 214, 145)},
                                             {4000000000u, "x", "", srgb(0, 0, 255)}};
    const std::string table = "# Color table file\r\n# 4 values\r\n0 background 0 0 0 0\r\n"
                              "1 tissue 128 174 128 255\r\n\r\n2\tbone of the hip  241 214 145 255\r\n"
                              "3 (none) 0 0 0 0\r\n4000000000 x 0 0 255 255";
    expectNames(read("a.ctbl", table), expected);
    expectNames(read("LUT.txt", table), expected);
    // Without opacities.
    expectNames(read("b.txt", "1 tissue 128 174 128\n2 bone of the hip 241 214 145\n4000000000 x 0 0 255\n"),
                expected);
}

TEST_F(LabelNames, LabelDescriptionsOfItkSnap) {
    const std::string text = "################\n# ITK-SnAP Label Description File\n"
                             "    0     0    0    0        0  0  0    \"Clear Label\"\n"
                             "    1   255    0    0        1  1  1    \"Label 1\"\n"
                             "    7     0  128  255      0.5  0  1    \"left kidney\"\n";
    for (const char* name : {"a.label", "b.txt"})
        expectNames(read(name, text),
                    {{1u, "Label 1", "", srgb(255, 0, 0)}, {7u, "left kidney", "", srgb(0, 128, 255)}});
}

TEST_F(LabelNames, Csv) {
    expectNames(read("a.csv", "1,liver,255,0,0\n5,\"kidney, \"\"left\"\"\",0,0,255\n"),
                {{1u, "liver", "", srgb(255, 0, 0)}, {5u, "kidney, \"left\"", "", srgb(0, 0, 255)}});
    expectNames(read("b.csv", "1,liver,#dd8265\n2,spleen,\n3,colon\n"),
                {{1u, "liver", "", srgb(0xdd, 0x82, 0x65)}, {2u, "spleen"}, {3u, "colon"}});
    expectNames(read("c.csv", "\xef\xbb\xbfLabelValue;Name;Color_R;Color_G;Color_B;Color_A;Group\n"
                              "0;none;0;0;0;0;\n8; liver ;0.0;1.0;0.0;255;organs\n"),
                {{8u, "liver", "organs", srgb(0, 255, 0)}});
    expectNames(read("d.csv", "name,colour\nliver,red\n"), {{std::nullopt, "liver", "", srgb(255, 0, 0)}});
}

TEST_F(LabelNames, Json) {
    expectNames(read("a.json", R"({"liver": "#dd8265", "colon": 3, "background": 0,
                                   "skull": {"value": 9, "color": [255, 0, 0], "group": "bones"}})"),
                {{3u, "colon"},
                 {std::nullopt, "liver", "", srgb(0xdd, 0x82, 0x65)},
                 {9u, "skull", "bones", srgb(255, 0, 0)}});
    expectNames(read("b.json", R"([{"value": 4294967295, "name": "liver", "colour": "red", "group": "organs"},
                                   {"value": 2, "colour": "#00ff00"}, {"name": "colon"}])"),
                {{4294967295u, "liver", "organs", srgb(255, 0, 0)},
                 {2u, "", "", srgb(0, 255, 0)},
                 {std::nullopt, "colon"}});
}

TEST_F(LabelNames, FaultsNameTheirPlace) {
    EXPECT_THAT(refusal("a.ctbl", "1 liver 255 0 0 255\n2 spleen 256 0 0 255\n"), HasSubstr("line 2"));
    EXPECT_THAT(refusal("a.ctbl", "1 liver 255 0 0 255\n1 spleen 25 0 0 255\n"),
                HasSubstr("every value once"));
    EXPECT_THAT(refusal("a.ctbl", "-1 liver 255 0 0 255\n"), HasSubstr("line 1"));
    EXPECT_THAT(refusal("a.ctbl", "liver\n"), HasSubstr("VALUE NAME R G B A"));
    EXPECT_THAT(refusal("a.ctbl", "# nothing\n"), HasSubstr("found none"));
    EXPECT_THAT(refusal("a.ctbl", std::string("\0\x01\x02\n", 4)), HasSubstr("\\x00"));
    EXPECT_THAT(refusal("a.label", "1 255 0 0 1 1 1 \"open\n"), HasSubstr("line 1"));
    EXPECT_THAT(refusal("a.csv", "1,liver,#dd82\n"), HasSubstr("#rrggbb"));
    EXPECT_THAT(refusal("a.csv", "1,liver,1,2,3000\n"), HasSubstr("from 0 to 255"));
    EXPECT_THAT(refusal("a.csv", "what,ever\n1,2\n"), HasSubstr("column value or name"));
    EXPECT_THAT(refusal("a.json", R"({"liver": "grean"})"), HasSubstr("$.liver"));
    EXPECT_THAT(refusal("a.json", R"([{"value": 1.5}])"), HasSubstr("$[0].value"));
    EXPECT_THAT(refusal("a.json", R"([{"vale": 1}])"), HasSubstr("vale"));
    EXPECT_THAT(refusal("a.json", R"([{"colour": "red"}])"), HasSubstr("a value or a name"));
    EXPECT_THAT(refusal("a.json", "7"), HasSubstr("a list of objects"));
    EXPECT_THAT(refusal("a.json", "{"), HasSubstr("a.json"));
    EXPECT_THROW(readLabelNames(folder_ / "gone.ctbl"), InputError);
}

/// Every word that a header may have for a column, in any case and order.
TEST_F(LabelNames, HeadersOfCsvHaveSeveralWords) {
    const std::vector<std::vector<std::string>> words = {{"value", "LabelValue", "index", "ID"},
                                                         {"name", "Label"},
                                                         {"r", "red", "Color_R"},
                                                         {"g", "green", "COLOR_G"},
                                                         {"b", "blue", "color_b"},
                                                         {"group", "Category"}};
    for (std::size_t n = 0; n < 4; ++n) {
        const auto word = [&](std::size_t column) {
            return words[column][std::min(n, words[column].size() - 1)];
        };
        const std::string header = word(5) + "," + word(4) + "," + word(3) + ",what," + word(2) + "," +
                                   word(1) + "," + word(0) + "\n";
        expectNames(read("a.csv", header + "organs,30,20,x,10,liver,5\n,,,,,colon,4294967295\n"),
                    {{5u, "liver", "organs", srgb(10, 20, 30)}, {4294967295u, "colon"}});
    }
    for (const char* colour : {"colour", "color", "Hex"})
        expectNames(read("b.csv", std::string("name;") + colour + "\nli,ver;#0a141e\n"),
                    {{std::nullopt, "li,ver", "", srgb(10, 20, 30)}});
    // without a header: three columns have a colour in the third, five and more red, green and blue
    expectNames(read("c.csv", "7,a,#0a141e\n"), {{7u, "a", "", srgb(10, 20, 30)}});
    expectNames(read("d.csv", "7,a,10,20,30\n8,b,10,20,30,99\n"),
                {{7u, "a", "", srgb(10, 20, 30)}, {8u, "b", "", srgb(10, 20, 30)}});
}

TEST_F(LabelNames, NumbersAreTakenUpToTheirBounds) {
    struct Row {
        const char* file;
        const char* text;
        bool isTaken;
    };
    for (const Row& row : {Row{"a.ctbl", "1 x 255 0 0 255", true},
                           {"a.ctbl", "1 x 255 0 256 255", false},
                           {"a.ctbl", "1 x 0.5 1.0 0.0 1", true},
                           {"a.ctbl", "1 x 0.5 1.001 0.0 1", false},
                           {"a.ctbl", "1 x -1 0 0 255", false},
                           {"a.ctbl", "1 x 1 2", false},
                           {"a.ctbl", "1 x 1 2 3", true},
                           {"a.ctbl", "1 1 2 3", false},
                           {"a.ctbl", "4294967295 x 1 2 3", true},
                           {"a.ctbl", "4294967296 x 1 2 3", false},
                           {"a.label", "1 2 3 4 1 1 1 \"x\"", true},
                           {"a.label", "1 2 3 4 1 1 \"x\"", false},
                           {"a.csv", "1,x,255,255,255", true},
                           {"a.csv", "1,x,255,256,255", false},
                           {"a.csv", "name,value\n,5", true},
                           {"a.csv", "name,value\n,", false},
                           {"a.json", R"({"x": 4294967295})", true},
                           {"a.json", R"({"x": 4294967296})", false},
                           {"a.json", R"({"x": -1})", false},
                           {"a.json", R"([{"value": 5}])", true},
                           {"a.json", R"([{"group": "g"}])", false},
                           {"a.json", R"([{"value": 5, "color": [0, 255, 1.5]}])", true},
                           {"a.json", R"([{"value": 5, "color": [0, 255.5, 1]}])", false},
                           {"a.json", R"([{"value": 5, "color": [0, -0.5, 1]}])", false},
                           {"a.json", R"([{"value": 5, "color": [0, 1]}])", false}})
        EXPECT_EQ(refusal(row.file, row.text).empty(), row.isTaken) << row.text;
    EXPECT_EQ(linearFromSrgb(1.0), static_cast<double>(read("b.ctbl", "1 x 0.0 1.0 0.5\n")[0].colour->g));
    // of a long line 60 characters are shown, and its number counts comments and empty lines
    const std::string wrong(61, 'w');
    EXPECT_THAT(refusal("a.ctbl", "# one\n\n  \n" + wrong + "\n"),
                testing::AllOf(HasSubstr("line 4"), HasSubstr("\"" + std::string(60, 'w') + "\"")));
}

TEST(ShippedNames, All117AndThoseOfVersion1) {
    const std::vector<LabelName>& names = totalSegmentatorNames();
    std::map<std::string, LabelName> byName;
    for (std::size_t i = 0; i < names.size(); ++i) {
        EXPECT_EQ(names[i].value, i < 117 ? std::optional(static_cast<std::uint32_t>(i + 1)) : std::nullopt);
        EXPECT_TRUE(names[i].colour) << names[i].name;
        EXPECT_FALSE(names[i].group.empty()) << names[i].name;
        EXPECT_TRUE(byName.emplace(names[i].name, names[i]).second) << names[i].name;
    }
    EXPECT_EQ(names.size(), 124u);
    for (const auto& [name, value] : std::map<std::string, std::uint32_t>{{"spleen", 1},
                                                                          {"liver", 5},
                                                                          {"sacrum", 25},
                                                                          {"vertebrae_S1", 26},
                                                                          {"vertebrae_L5", 27},
                                                                          {"vertebrae_T12", 32},
                                                                          {"vertebrae_C1", 50},
                                                                          {"heart", 51},
                                                                          {"aorta", 52},
                                                                          {"iliac_vena_right", 68},
                                                                          {"brain", 90},
                                                                          {"rib_left_1", 92},
                                                                          {"rib_right_12", 115},
                                                                          {"costal_cartilages", 117}})
        EXPECT_EQ(byName.at(name).value, value) << name;
    const auto luv = [&](const std::string& name) {
        return luvFromLinear(glm::dvec3(*byName.at(name).colour));
    };
    for (const auto& [name, entry] : byName) { // arteries are red, veins blue, bones light
        const glm::vec3 c = *entry.colour;
        if (name.find("artery") != std::string::npos || name == "aorta") {
            EXPECT_TRUE(c.r > 2 * c.g && c.r > c.b) << name;
        }
        if (name.find("vein") != std::string::npos || name.find("vena") != std::string::npos) {
            EXPECT_TRUE(c.b > c.r && c.b > c.g) << name;
        }
        if (entry.group == "ribs" || entry.group == "vertebrae" || entry.group == "skeleton") {
            EXPECT_GT(luv(name).x, 70) << name;
        }
        if (entry.group == "muscles") {
            EXPECT_TRUE(luv(name).x < 45 && c.r > 3 * c.g) << name;
        }
    }
    const auto expectApart = [&](const std::string& a, const std::string& b) {
        EXPECT_GT(glm::length(luv(a) - luv(b)), 8) << a << " " << b;
    };
    for (std::uint32_t value = 26; value < 50; ++value) // neighbours of the spine
        expectApart(names[value - 1].name, names[value].name);
    for (const std::string side : {"left", "right"})
        for (int rib = 1; rib < 12; ++rib)
            expectApart("rib_" + side + "_" + std::to_string(rib),
                        "rib_" + side + "_" + std::to_string(rib + 1));
}

TEST(ShippedNames, HaveEveryMaskOfVersion1) {
    if (testData().empty())
        GTEST_SKIP() << "no shared test data (TESSERA_TEST_DATA or ../shared/data)";
    std::set<std::string> known;
    for (const LabelName& name : totalSegmentatorNames())
        known.insert(name.name);
    std::size_t masks = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(testData() / "labels/totalsegmentator/masks")) {
        const std::string name = entry.path().filename().string();
        EXPECT_TRUE(known.contains(name.substr(0, name.find('.')))) << name;
        ++masks;
    }
    EXPECT_EQ(masks, 104u);
}

TEST(LabelNaming, ByValueElseByName) {
    LabelTable table;
    table.labels = {{1, "one"}, {2, "Liver", "mine", glm::vec3(1)}, {5, "label 5"}, {6, "label 6"}};
    const std::vector<LabelName> names = {{5u, "colon", "organs", glm::vec3(0, 1, 0)},
                                          {std::nullopt, "liver", "", glm::vec3(1, 0, 0)},
                                          {std::nullopt, "label 5", "", glm::vec3(0, 0, 1)},
                                          {1u, "", "", glm::vec3(0.5)},
                                          {77u, "nobody"}};
    applyNames(table, names);
    EXPECT_EQ(table.labels, (std::vector<Label>{{1, "one", "", glm::vec3(0.5)},
                                                {2, "Liver", "mine", glm::vec3(1, 0, 0)},
                                                {5, "colon", "organs", glm::vec3(0, 1, 0)},
                                                {6, "label 6"}}));
    table.labels = {{1, "Spleen"}, {2, "liver", "mine", glm::vec3(1)}, {3, "unheard of"}};
    applyKnownNames(table);
    EXPECT_EQ(table.labels[0].colour, totalSegmentatorNames()[0].colour);
    EXPECT_EQ(table.labels[0].group, "organs");
    EXPECT_EQ(table.labels[0].name, "Spleen");
    EXPECT_EQ(table.labels[1], (Label{2, "liver", "mine", glm::vec3(1)}));
    EXPECT_EQ(table.labels[2], (Label{3, "unheard of"}));
}

TEST(LabelColours, AreFixedAndApart) {
    std::vector<glm::dvec3> luv;
    for (std::uint32_t value = 1; value <= 40; ++value) {
        const glm::vec3 colour = labelColour(value);
        for (int i = 0; i < 3; ++i)
            EXPECT_TRUE(colour[i] >= 0 && colour[i] <= 1);
        luv.push_back(luvFromLinear(glm::dvec3(colour)));
        EXPECT_TRUE(luv.back().x > 45 && luv.back().x < 92) << value;
    }
    double least = 1e9;
    for (std::size_t i = 0; i < luv.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (const double apart = glm::length(luv[i] - luv[j]); i - j < 8)
                EXPECT_GT(apart, 25) << i + 1 << " " << j + 1;
            else
                least = std::min(least, apart);
    EXPECT_GT(least, 6);
    EXPECT_EQ(labelColour(7), labelColour(7));
    labelColour(4294967295u);
    labelColour(0);
}

/// A label keeps its colour from version to version.
TEST(LabelColours, AreThoseOfTheRecord) {
    RecordedNumbers record("tests/bricking/labels/recorded/colours.txt");
    for (const std::uint32_t value : {0u, 1u, 2u, 3u, 5u, 8u, 10u, 11u, 117u, 65534u, 4294967295u}) {
        const glm::vec3 colour = labelColour(value);
        record.expect(std::to_string(value), {static_cast<double>(colour.r), static_cast<double>(colour.g),
                                              static_cast<double>(colour.b)});
    }
}

TEST(LabelPatterns, NamesGlobsValuesAndGroups) {
    const Label rib{93, "rib_left_2", "Ribs", {}}, kidney{7, "ni\xc3\xa9re gauche", "", {}},
        odd{3, "7", "a*b", {}};
    struct Row {
        const Label& label;
        const char* pattern;
        bool matches;
    };
    for (const Row& row : {Row{rib, "rib_left_2", true},
                           Row{rib, "RIB_Left_2", true},
                           Row{rib, "rib_left", false},
                           Row{rib, "rib_*", true},
                           Row{rib, "*", true},
                           Row{rib, "*left*", true},
                           Row{rib, "*_l*_2", true},
                           Row{rib, "rib_left_?", true},
                           Row{rib, "rib_left_2?", false},
                           Row{rib, "?ib*", true},
                           Row{rib, "*ib", false},
                           Row{rib, "93", true},
                           Row{rib, "9", false},
                           Row{rib, "9*", false}, // of names alone
                           Row{rib, "group:ribs", true},
                           Row{rib, "Group:R?b*", true},
                           Row{rib, "group:rib", false},
                           Row{rib, "ribs", false},
                           Row{rib, "", false},
                           Row{kidney, "ni?re gauche", true}, // one character of two bytes
                           Row{kidney, "ni??re gauche", false},
                           Row{kidney, "7", true},
                           Row{kidney, "group:*", false}, // it has no group
                           Row{odd, "7", true},           // its name
                           Row{odd, "3", true},
                           Row{odd, "group:a*b", true}})
        EXPECT_EQ(labelMatches(row.label, row.pattern), row.matches) << row.label.name << " " << row.pattern;
    // In time of text times pattern.
    EXPECT_FALSE(labelMatches({1, std::string(5000, 'a')}, "*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*b"));
}

TEST(LabelPatterns, NearestNames) {
    LabelTable table;
    for (const LabelName& name : totalSegmentatorNames())
        if (name.value)
            table.labels.push_back({*name.value, name.name, name.group, name.colour});
    EXPECT_EQ(nearestNames(table, "livr").front(), "liver");
    EXPECT_EQ(nearestNames(table, "SPLEEM*", 1), (std::vector<std::string>{"spleen"}));
    EXPECT_THAT(nearestNames(table, "kidney"), testing::IsSupersetOf({"kidney_left", "kidney_right"}));
    EXPECT_EQ(nearestNames(table, "group:muscle").front(), "group:muscles");
    EXPECT_EQ(nearestNames(table, "xyz", 5).size(), 5u);
    EXPECT_THAT(nearestNames(LabelTable{}, "x"), IsEmpty());
}

} // namespace
} // namespace tessera::test

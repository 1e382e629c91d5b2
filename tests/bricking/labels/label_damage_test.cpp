// tests/bricking/labels/label_damage_test.cpp: a volume of labels that is damaged or lies is refused by name,
// or reads as it was.
#include "tests/support/label_tools.h"

#include "bricking/labels/label_files.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "bricking/store/zarr_array.h"
#include "core/base/error.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

class DamagedLabels : public testing::Test {
  protected:
    void SetUp() override {
        const VolumeInfo scan = plainInfo({37, 21, 26}, ValueType::i16);
        LabelFile file = fileOf({HeldLayer(scan, blobs(scan.extentVoxels, {1, 2}, 3)),
                                 HeldLayer(scan, blobs(scan.extentVoxels, {5, 9}, 4))},
                                {{1, "liver", "organs", glm::vec3(1, 0.5f, 0)}, {9, "vessel"}});
        importAtFloor(file, scan, path);
        whole = readBack(path);
        for (const auto& entry : fs::recursive_directory_iterator(path))
            if (entry.is_regular_file())
                files.push_back(entry.path());
    }
    /// True if refused; else it must be what it was.
    bool refused(const std::string& trace, const fs::path& named) const {
        SCOPED_TRACE(trace);
        try {
            const ReadBack now = readBack(path);
            EXPECT_TRUE(now.table == whole.table);
            EXPECT_TRUE(now.levels == whole.levels);
            EXPECT_TRUE(now.cells.first == whole.cells.first && now.cells.shares == whole.cells.shares);
            return false;
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(),
                        HasSubstr(named.filename() == "zarr.json"
                                      ? named.string()
                                      : named.parent_path().parent_path().parent_path().string()));
            return true;
        }
    }
    /// Changes the table's document, and seals it again as a forger would.
    void forge(const std::function<void(Json&)>& change) const {
        const fs::path file = path / "sets/zarr.json";
        Json document = parseJson(fileText(file), "");
        change(document["attributes"]["tessera"]);
        seal(document);
        setFileText(file, document.dump());
    }
    std::string refusalOf() const {
        try {
            MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
            const LabelVolume volume(path, ram);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }
    ScratchFolder scratch;
    fs::path path = scratch / "l.zarr";
    ReadBack whole;
    std::vector<fs::path> files;
};

TEST_F(DamagedLabels, EveryTruncatedFileIsRefused) {
    ASSERT_GE(files.size(), 17u); // of levels, their arrays, the table and three arrays
    for (const fs::path& file : files) {
        const std::string text = fileText(file);
        for (const std::size_t length : {std::size_t{0}, text.size() / 3, text.size() - 2}) {
            setFileText(file, text.substr(0, length));
            EXPECT_TRUE(refused(file.string() + " " + std::to_string(length), file));
        }
        fs::remove(file);
        EXPECT_TRUE(refused(file.string(), file));
        setFileText(file, text);
    }
    EXPECT_FALSE(refused("mended", path));
}

TEST_F(DamagedLabels, AFlippedBitIsRefusedOrWithoutEffect) {
    std::mt19937 random(6);
    std::size_t all = 0, caught = 0;
    for (const fs::path& file : files) {
        const std::string text = fileText(file);
        for (int i = 0; i < 12; ++i, ++all) {
            std::string flipped = text;
            const std::size_t bit = random() % (8 * text.size());
            flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
            setFileText(file, flipped);
            caught += refused(file.string() + " bit " + std::to_string(bit), file);
        }
        setFileText(file, text);
    }
    EXPECT_GT(caught, all / 2); // blanks of JSON may change into other blanks
}

TEST_F(DamagedLabels, AWholeFileOfAnotherStoreIsRefused) {
    const VolumeInfo scan = plainInfo({37, 21, 26}, ValueType::i16);
    LabelFile file = fileOf({HeldLayer(scan, blobs(scan.extentVoxels, {1, 2}, 8)),
                             HeldLayer(scan, blobs(scan.extentVoxels, {5, 9}, 9))});
    importAtFloor(file, scan, scratch / "other.zarr");
    for (const char* part : {"counts", "set", "voxels"}) {
        const fs::path chunk = fs::path("sets") / part / "c/0/0/0";
        const std::string text = fileText(path / chunk);
        setFileText(path / chunk, fileText(scratch / "other.zarr" / chunk));
        EXPECT_THAT(refusalOf(), HasSubstr((path / "sets").string())) << part;
        setFileText(path / chunk, text);
    }
    const std::string text = fileText(path / "sets/zarr.json");
    setFileText(path / "sets/zarr.json", fileText(scratch / "other.zarr/sets/zarr.json"));
    EXPECT_THAT(refusalOf(), HasSubstr("that of another"));
    setFileText(path / "sets/zarr.json", text);
    EXPECT_EQ(refusalOf(), "");
    fs::remove_all(path / "sets");
    EXPECT_THAT(refusalOf(), HasSubstr("no such file"));
}

TEST_F(DamagedLabels, ALyingTableIsRefused) {
    const std::string text = fileText(path / "sets/zarr.json");
    const std::vector<std::pair<const char*, std::function<void(Json&)>>> lies = {
        {"another version", [](Json& t) { t["version"] = 2; }},
        {"a label without a name", [](Json& t) { t["labels"][0]["name"] = ""; }},
        {"a label 0", [](Json& t) { t["labels"][0]["value"] = 0; }},
        {"a negative label", [](Json& t) { t["labels"][0]["value"] = -3; }},
        {"a label too large", [](Json& t) { t["labels"][3]["value"] = 4294967296u; }},
        {"labels out of order", [](Json& t) { std::swap(t["labels"][0], t["labels"][1]); }},
        {"a label that is none", [](Json& t) { t["labels"][0] = 7; }},
        {"no labels", [](Json& t) { t.erase("labels"); }},
        {"labels that are no list", [](Json& t) { t["labels"] = "all"; }},
        {"a bad colour",
         [](Json& t) {
             t["labels"][0]["colour"] = {2, 0, 0};
         }},
        {"half a colour",
         [](Json& t) {
             t["labels"][0]["colour"] = {1, 0};
         }},
        {"a group without a name", [](Json& t) { t["labels"][0]["group"] = 3; }},
        {"a set of an unknown label", [](Json& t) { t["sets"][1] = {4}; }},
        {"a set that is no list", [](Json& t) { t["sets"][1] = Json(t["sets"][1][0]); }},
        {"an empty set more", [](Json& t) { t["sets"][1] = Json::array(); }},
        {"a first set with a label", [](Json& t) { t["sets"][0] = {0}; }},
        {"sets out of order", [](Json& t) { std::swap(t["sets"][1], t["sets"][2]); }},
        {"a set twice", [](Json& t) { t["sets"][2] = t["sets"][1]; }},
        {"no sets", [](Json& t) { t["sets"] = Json::array(); }},
        {"a set less", [](Json& t) { t["sets"].erase(t["sets"].size() - 1); }},
        {"a share more", [](Json& t) { t["shares"] = t["shares"].get<int>() + 1; }},
        {"a share less", [](Json& t) { t["shares"] = t["shares"].get<int>() - 1; }},
        {"shares beyond measure", [](Json& t) { t["shares"] = 2000000000; }},
        {"another sum", [](Json& t) { t["crc"][1] = 1; }},
    };
    for (const auto& [what, change] : lies) {
        forge(change);
        EXPECT_THAT(refusalOf(), HasSubstr((path / "sets").string())) << what;
        setFileText(path / "sets/zarr.json", text);
    }
    forge([](Json& t) { t["labels"][0]["name"] = "kidney"; });
    EXPECT_EQ(refusalOf(), "") << "what a forger seals is only wrong where it contradicts itself";
    setFileText(path / "sets/zarr.json", "{\"attributes\": " + std::string(100000, '[') + "}");
    EXPECT_THAT(refusalOf(), HasSubstr("too deep"));
}

TEST_F(DamagedLabels, CellsThatContradictThemselvesAreRefused) {
    const std::size_t cells = whole.cells.first.size() - 1, shares = whole.cells.shares.size();
    std::vector<std::uint16_t> counts(cells), sets(shares), voxels(shares);
    for (std::size_t i = 0; i < cells; ++i)
        counts[i] = static_cast<std::uint16_t>(whole.cells.first[i + 1] - whole.cells.first[i]);
    for (std::size_t i = 0; i < shares; ++i) {
        sets[i] = whole.cells.shares[i].set;
        voxels[i] = whole.cells.shares[i].voxels;
    }
    // A cell with two shares or more.
    const auto several = static_cast<std::size_t>(
        std::find_if(counts.begin(), counts.end(), [](auto count) { return count > 1; }) - counts.begin());
    ASSERT_LT(several, cells);
    const std::size_t at = whole.cells.first[several];
    const auto rewrite = [&](const char* name, std::size_t crc, const std::vector<std::uint16_t>& values) {
        const ArraySpec spec{"uint16", 2, {1, 1, static_cast<int>(values.size())}, {1, 1, 1 << 18}, 0};
        fs::remove(path / "sets" / name / "c/0/0/0"); // writing does not shorten
        writeArrayLayer(path / "sets" / name, spec, 0, std::as_bytes(std::span(values)));
        forge([&](Json& t) { t["crc"][crc] = crc32c(std::as_bytes(std::span(values))); });
    };
    const auto changed = [](std::vector<std::uint16_t> values, std::size_t i, int by) {
        values[i] = static_cast<std::uint16_t>(values[i] + by);
        return values;
    };
    const auto swapped = [](std::vector<std::uint16_t> values, std::size_t i) {
        std::swap(values[i], values[i + 1]);
        return values;
    };
    rewrite("voxels", 2, changed(voxels, at, 1));
    EXPECT_THAT(refusalOf(), AllOf(HasSubstr("sets/voxels"), HasSubstr("voxels in a cell")));
    rewrite("voxels", 2, changed(voxels, at, -static_cast<int>(voxels[at])));
    EXPECT_THAT(refusalOf(), HasSubstr("sets/voxels"));
    rewrite("voxels", 2, changed(changed(voxels, at, -static_cast<int>(voxels[at])), at + 1, voxels[at]));
    EXPECT_THAT(refusalOf(), AllOf(HasSubstr("sets/voxels"), HasSubstr("at least one voxel")));
    rewrite("voxels", 2, voxels);
    EXPECT_EQ(refusalOf(), "");
    rewrite("set", 1, changed(sets, at, 1000));
    EXPECT_THAT(refusalOf(), AllOf(HasSubstr("sets/set"), HasSubstr("ascending sets")));
    rewrite("set", 1, swapped(sets, at));
    EXPECT_THAT(refusalOf(), HasSubstr("ascending sets"));
    rewrite("set", 1, sets);
    rewrite("counts", 0, changed(counts, several, 600));
    EXPECT_THAT(refusalOf(), HasSubstr("sets/counts"));
    rewrite("counts", 0, changed(counts, several, -static_cast<int>(counts[several])));
    EXPECT_THAT(refusalOf(), HasSubstr("sets/counts"));
    rewrite("counts", 0, changed(counts, several, -1));
    EXPECT_THAT(refusalOf(), HasSubstr("sets"));
}

TEST_F(DamagedLabels, CellsTakeMemoryOfTheBudget) {
    std::size_t least = 0;
    for (std::size_t budget = std::size_t{32} << 10; least == 0; budget += budget / 8) {
        MemoryBudget ram("RAM", "--ram", budget);
        try {
            const LabelVolume volume(path, ram);
            least = budget;
            EXPECT_GE(ram.usedBytes(), whole.cells.shares.size() * 4 + whole.cells.first.size() * 4);
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr("--ram"));
        }
        EXPECT_LE(ram.peakBytes(), budget);
        EXPECT_EQ(ram.usedBytes(), 0u);
    }
    EXPECT_GT(least, std::size_t{1} << 20);
}

TEST_F(DamagedLabels, OthersSeeColoursAndNames) {
    const Json ome = parseJson(fileText(path / "zarr.json"), "").at("attributes").at("ome");
    EXPECT_FALSE(ome.contains("omero"));
    EXPECT_EQ(ome.at("multiscales").at(0).at("type"), "mode");
    const Json& shown = ome.at("image-label");
    EXPECT_EQ(shown.at("properties").size(), whole.table.sets.size() - 1);
    for (const Json& row : shown.at("properties")) {
        const auto& set = whole.table.sets.at(row.at("label-value").get<std::size_t>());
        ASSERT_EQ(row.at("names").size(), set.size());
        EXPECT_EQ(row.at("names").at(0), whole.table.labels[set[0]].name);
    }
    EXPECT_EQ(shown.at("colors").at(0), Json({{"label-value", 1}, {"rgba", {255, 188, 0, 255}}}));
}

/// Colours in 8 bits of sRGB; of a set the mean of its coloured labels, none of uncoloured ones.
TEST(ImageLabel, SetsHaveTheMeanOfTheirColours) {
    LabelTable table;
    table.labels = {{3, "a", "", glm::vec3(0.002f, 0.0031f, 0.0034f)},
                    {4, "b", "", glm::vec3(0.2f, 0.6f, 1)},
                    {9, "c"},
                    {11, "d", "", glm::vec3(0.4f, 0.1f, 0)}};
    table.sets = {{}, {0}, {1}, {2}, {1, 3}, {0, 2}};
    const Json shown = parseJson(imageLabelOf(table), "");
    ASSERT_EQ(shown.at("properties").size(), 5u);
    EXPECT_EQ(shown.at("properties").at(3),
              Json({{"label-value", 4}, {"names", {"b", "d"}}, {"values", {4, 11}}}));
    const auto srgb = [](double linear) {
        return static_cast<int>(std::lround(
            255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055)));
    };
    const auto colour = [&](int number, double r, double g, double b) {
        return Json({{"label-value", number}, {"rgba", {srgb(r), srgb(g), srgb(b), 255}}});
    };
    EXPECT_EQ(shown.at("colors"), Json({colour(1, 0.002, 0.0031, 0.0034), colour(2, 0.2, 0.6, 1),
                                        colour(4, 0.3, 0.35, 0.5), colour(5, 0.002, 0.0031, 0.0034)}));
    table.labels[0].colour = table.labels[1].colour = table.labels[3].colour = {};
    EXPECT_FALSE(parseJson(imageLabelOf(table), "").contains("colors"));
}

/// Other programs are told of up to 4096 sets.
TEST(ImageLabel, VeryManySetsAreNotShown) {
    LabelTable table;
    for (std::uint32_t i = 0; i < 4096; ++i) {
        table.labels.push_back({i + 1, "n"});
        if (table.sets.size() < 4096)
            table.sets.push_back({static_cast<std::uint16_t>(i)});
    }
    ASSERT_EQ(table.sets.size(), 4096u);
    EXPECT_FALSE(imageLabelOf(table).empty());
    table.sets.push_back({4095});
    EXPECT_EQ(imageLabelOf(table), "");
}

} // namespace
} // namespace tessera

// tests/bricking/validate/validate_test.cpp: whatever is damaged in a store is found, alone, by name; what
// follows from the rest is made again byte for byte.
#include "tests/support/bricking_store_tools.h"
#include "tests/support/label_tools.h"

#include "bricking/statistics/local_histograms.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/codec.h"
#include "bricking/store/shard.h"
#include "bricking/store/store_writer.h"
#include "bricking/store/zarr_array.h"
#include "bricking/validate/validate_store.h"
#include "core/base/ownership.h"

#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <random>

namespace tessera {
namespace {

using namespace test;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

using Files = std::map<std::string, std::string>; // path below the folder -> bytes; "/" for folders

Files filesIn(const fs::path& folder) {
    Files files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        const std::string name = entry.path().lexically_relative(folder).string();
        if (entry.is_regular_file())
            files[name] = fileText(entry.path());
        else
            files[name + "/"] = "";
    }
    return files;
}

/// Names in which two folders differ.
std::vector<std::string> differences(const Files& a, const Files& b) {
    std::vector<std::string> names;
    for (const auto& [name, text] : a)
        if (const auto other = b.find(name); other == b.end() || other->second != text)
            names.push_back(name);
    for (const auto& [name, text] : b)
        if (!a.contains(name))
            names.push_back(name);
    return names;
}

ValidateReport validate(const fs::path& store, bool repair = false, bool thorough = false,
                        std::size_t budget = kPlenty, int threads = 2) {
    MemoryBudget ram("RAM", "--ram", budget);
    ValidateOptions options;
    options.repair = repair;
    options.thorough = thorough;
    options.threads = threads;
    const ValidateReport report = validateStore(store, ram, options);
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_LE(ram.peakBytes(), budget);
    EXPECT_EQ(report.faults, report.lines.size());
    return report;
}

void flipByte(const fs::path& file, std::size_t at, char mask = 0x10) {
    std::string text = fileText(file);
    text.at(at) = static_cast<char>(text.at(at) ^ mask);
    setFileText(file, text);
}

/// The entries of a shard of so many chunks.
std::vector<ShardEntry> indexOf(const std::string& shard, std::size_t chunks) {
    std::vector<ShardEntry> entries(chunks);
    std::memcpy(entries.data(), shard.data() + shard.size() - 16 * chunks - 4, 16 * chunks);
    return entries;
}

/// A store of 70x47x65 voxels in HU: 3x2x3 chunks at level 0, 2x1x2 at level 1, one above.
class ValidatedStore : public testing::Test {
  protected:
    void SetUp() override {
        VolumeInfo info = plainInfo({70, 47, 65}, ValueType::i16);
        info.unit = "HU";
        info.fillStored = -1000;
        // A corner is fill alone, so that chunks are left out.
        HashSource source(info, [](int x, int y, int z) {
            return x >= 64 && z < 32
                       ? -1000.0
                       : static_cast<double>((x * 7919 + y * 104729 + z * 1299709) % 2000 - 1000);
        });
        import(path, source);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(path, ram);
        LocalHistogramSettings settings;
        settings.radiusMm = 4;
        settings.representatives = 64;
        const Statistics statistics = loadStatistics(store, ram, 1);
        localHistogramsOf(store, store, 0, statistics, settings, ram, 1);
        whole = filesIn(path);
        ASSERT_TRUE(whole.contains("stats/table/zarr.json"));
        ASSERT_TRUE(whole.contains("stats/histograms/zarr.json"));
    }
    void restore() const {
        fs::remove_all(path);
        for (const auto& [name, text] : whole)
            if (name.back() == '/')
                fs::create_directories(path / name);
            else {
                fs::create_directories((path / name).parent_path());
                setFileText(path / name, text);
            }
    }
    /// The damage is found, alone and by these words, and nothing is written.
    void expectFound(const std::string& what, const std::vector<std::string>& words) const {
        const Files before = filesIn(path);
        const ValidateReport report = validate(path);
        ASSERT_EQ(report.lines.size(), 1u) << what << "\n" << testing::PrintToString(report.lines);
        for (const std::string& word : words)
            EXPECT_THAT(report.lines[0], HasSubstr(word)) << what;
        EXPECT_EQ(report.mended, 0u);
        EXPECT_THAT(differences(before, filesIn(path)), IsEmpty()) << what;
    }
    void expectMended(const std::string& what) const {
        const ValidateReport report = validate(path, true);
        EXPECT_EQ(report.mended, report.faults) << what << "\n" << testing::PrintToString(report.lines);
        EXPECT_THAT(differences(whole, filesIn(path)), IsEmpty()) << what;
        EXPECT_THAT(validate(path).lines, IsEmpty()) << what;
    }
    void expectLeft(const std::string& what, const std::string& why) const {
        const Files before = filesIn(path);
        const ValidateReport report = validate(path, true);
        EXPECT_EQ(report.mended, 0u) << what;
        ASSERT_EQ(report.lines.size(), 1u) << what;
        EXPECT_THAT(report.lines[0], HasSubstr("stays: " + why)) << what;
        EXPECT_THAT(differences(before, filesIn(path)), IsEmpty()) << what;
    }
    ScratchFolder scratch;
    fs::path path = scratch / "v.zarr";
    Files whole;
};

TEST_F(ValidatedStore, AWholeOneHasNoFault) {
    const ValidateReport report = validate(path);
    EXPECT_THAT(report.lines, IsEmpty());
    EXPECT_THAT(report.notes, IsEmpty());
    EXPECT_EQ(report.shards, 6u);
    EXPECT_EQ(report.chunks, 16u + 4 + 4)
        << "3x2x3 but for the 2 of fill, 2x1x2, and one of each level above";
    EXPECT_THAT(validate(path, true, true).lines, IsEmpty());
    EXPECT_THAT(differences(whole, filesIn(path)), IsEmpty());
    EXPECT_EQ(entriesIn(scratch.path()), 1u);
}

TEST_F(ValidatedStore, EveryKindOfDamageThatFollowsFromTheRestIsFoundAndMended) {
    struct Damage {
        std::string what;
        std::function<void()> make;
        std::vector<std::string> words;
    };
    const std::string coarse = "1/c/0/0/0";
    const auto entries = indexOf(whole.at(coarse), 4);
    const auto reindexed = [&](const std::vector<ShardEntry>& changed) {
        std::string text = whole.at(coarse);
        const auto bytes = encodeIndex(changed);
        text.resize(text.size() - bytes.size());
        text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        return text;
    };
    const std::vector<Damage> damages = {
        {"a bit of a coarse chunk",
         [&] { flipByte(path / coarse, entries[2].offset + entries[2].bytes / 2); },
         {"v.zarr/1/c/0/0/0", "level 1 chunk (0,0,1)", "expected checksum", "the data is damaged"}},
        {"a chunk's own checksum",
         [&] { flipByte(path / coarse, entries[3].offset + entries[3].bytes - 1); },
         {"v.zarr/1/c/0/0/0", "level 1 chunk (1,0,1)", "expected checksum"}},
        {"the coarsest chunk",
         [&] { flipByte(path / "5/c/0/0/0", 20); },
         {"v.zarr/5/c/0/0/0", "level 5 chunk (0,0,0)"}},
        {"a shard cut short", [&] { fs::resize_file(path / coarse, 100); }, {coarse}},
        {"a shard that is a few bytes", [&] { fs::resize_file(path / coarse, 3); }, {coarse, "cut short"}},
        {"a longer shard", [&] { setFileText(path / coarse, whole.at(coarse) + "more"); }, {coarse}},
        {"a bit of an index",
         [&] { flipByte(path / coarse, whole.at(coarse).size() - 30); },
         {coarse, "a damaged index"}},
        {"an index that lies",
         [&] {
             setFileText(path / coarse, reindexed({entries[1], entries[0], entries[2], entries[3]}));
         },
         {coarse, "expected the shard that zarr.json describes"}},
        {"a shard that is lost", [&] { fs::remove(path / coarse); }, {coarse, "no such file"}},
        {"a level's metadata",
         [&] { flipByte(path / "3/zarr.json", 40); },
         {"v.zarr/3/zarr.json", "expected"}},
        {"a wrong attribute",
         [&] {
             std::string text = whole.at("0/zarr.json");
             text.replace(text.find("-1000"), 5, "-1001");
             setFileText(path / "0/zarr.json", text);
         },
         {"v.zarr/0/zarr.json", "/fill_value to be -1000, found -1001"}},
        {"white space of the group",
         [&] { setFileText(path / "zarr.json", whole.at("zarr.json") + " "); },
         {"v.zarr/zarr.json", "white space"}},
        {"a level's metadata that is lost", [&] { fs::remove(path / "5/zarr.json"); }, {"5/zarr.json"}},
        {"rays that are lost",
         [&] { fs::remove_all(path / "stats/rays"); },
         {"v.zarr/stats/rays: expected an array, found no such folder"}},
        {"a range of cells",
         [&] { flipByte(path / "stats/cell_min/c/0/0/0", 30); },
         {"stats/cell_min/c/0/0/0"}},
        {"a range of bricks that is lost",
         [&] { fs::remove(path / "stats/brick_max/c/0/0/0"); },
         {"stats/brick_max/c/0/0/0", "no such file"}},
        {"an array's metadata",
         [&] { flipByte(path / "stats/cell_max/zarr.json", 60); },
         {"stats/cell_max/zarr.json"}},
        {"another array",
         [&] { setFileText(path / "stats/brick_min/c/0/0/0", whole.at("stats/brick_max/c/0/0/0")); },
         {"stats/brick_min", "another"}},
        {"the histogram",
         [&] {
             std::string text = whole.at("stats/zarr.json");
             text.replace(text.find("\"histogram\""), 11, "\"histogran\"");
             setFileText(path / "stats/zarr.json", text);
         },
         {"stats/zarr.json", "checksum"}},
        {"rays", [&] { flipByte(path / "stats/rays/1/c/0/0/0/0", 40); }, {"stats/rays/1/c/0/0/0/0"}},
        {"the table", [&] { flipByte(path / "stats/table/zarr.json", 70); }, {"stats/table/zarr.json"}},
        {"an unfinished file of a killed program",
         [&] { setFileText(path / "1/.0.tessera-7-0", "half"); },
         {"1/.0.tessera-7-0", "when it was killed"}},
        {"an unfinished folder of a killed program",
         [&] {
             fs::create_directories(path / "stats/.table.importing-7-0");
             setFileText(path / "stats/.table.importing-7-0/zarr.json", "half");
         },
         {"stats/.table.importing-7-0"}},
        {"an import that was killed",
         [&] { fs::create_directories(scratch / ".v.zarr.importing-7-0/0"); },
         {".v.zarr.importing-7-0"}},
    };
    for (const Damage& damage : damages) {
        SCOPED_TRACE(damage.what);
        damage.make();
        expectFound(damage.what, damage.words);
        expectMended(damage.what);
        EXPECT_EQ(entriesIn(scratch.path()), 1u);
        restore();
    }
}

TEST_F(ValidatedStore, WhatFollowsFromNothingStaysAndIsTold) {
    const auto entries = indexOf(whole.at("0/c/0/0/0"), 18);
    flipByte(path / "0/c/0/0/0", entries[4].offset + entries[4].bytes / 2);
    expectFound("a bit of level 0", {"v.zarr/0/c/0/0/0", "level 0 chunk (1,1,0)", "expected checksum"});
    expectLeft("a bit of level 0", "level 0 is made by an import alone");
    restore();
    fs::resize_file(path / "0/c/0/0/0", 1000);
    expectFound("level 0 cut short", {"v.zarr/0/c/0/0/0"});
    expectLeft("level 0 cut short", "level 0 is made by an import alone");
    restore();
    fs::remove(path / "0/c/0/0/0");
    expectFound("level 0 lost", {"v.zarr/0/c/0/0/0", "no such file"});
    restore();
    flipByte(path / "zarr.json", whole.at("zarr.json").find("extentVoxels") + 3);
    expectFound("the group", {"v.zarr/zarr.json", "expected"});
    expectLeft("the group", "it is made by an import alone");
    restore();
    fs::remove(path / "zarr.json");
    expectFound("no group", {"v.zarr/zarr.json", "no such file"});
    restore();
}

TEST_F(ValidatedStore, LocalHistogramsThatAreDamagedAreRemoved) {
    for (const char* file : {"stats/histograms/zarr.json", "stats/histograms/numbers/c/0/0/0"}) {
        flipByte(path / file, 45);
        expectFound(file, {file});
        EXPECT_EQ(validate(path, true).mended, 1u);
        EXPECT_FALSE(fs::exists(path / "stats/histograms"));
        EXPECT_THAT(validate(path).lines, IsEmpty());
        restore();
    }
}

TEST_F(ValidatedStore, AllThatFollowsFromLevel0IsMadeAgainFromIt) {
    for (int level = 1; level < kLevelCount; ++level)
        fs::remove_all(path / std::to_string(level));
    fs::remove_all(path / "stats");
    const ValidateReport report = validate(path, true);
    EXPECT_EQ(report.mended, report.faults);
    Files made = whole;
    std::erase_if(made, [](const auto& file) { // which are found or made at first use
        return file.first.starts_with("stats/table") || file.first.starts_with("stats/histograms");
    });
    EXPECT_THAT(differences(made, filesIn(path)), IsEmpty());
    EXPECT_THAT(validate(path).lines, IsEmpty());
}

TEST_F(ValidatedStore, AChunkAboveADamagedOneStaysWhereItIsDamagedToo) {
    const auto finest = indexOf(whole.at("0/c/0/0/0"), 18);
    const auto coarse = indexOf(whole.at("1/c/0/0/0"), 4);
    flipByte(path / "0/c/0/0/0", finest[0].offset + 40);
    flipByte(path / "1/c/0/0/0", coarse[0].offset + 40); // above it
    flipByte(path / "2/c/0/0/0", 40);                    // follows from level 1
    flipByte(path / "4/c/0/0/0", 40);                    // follows from level 3, which is whole
    flipByte(path / "stats/cell_min/c/0/0/0", 40);
    const ValidateReport report = validate(path, true);
    ASSERT_EQ(report.faults, 5u) << testing::PrintToString(report.lines);
    EXPECT_EQ(report.mended, 1u);
    EXPECT_THAT(
        report.lines,
        ElementsAre(AllOf(HasSubstr("level 0 chunk (0,0,0)"), HasSubstr("stays: ")),
                    AllOf(HasSubstr("level 1 chunk (0,0,0)"),
                          HasSubstr("stays: chunks of level 0 under level 1 chunk (0,0,0) are damaged")),
                    AllOf(HasSubstr("level 2 chunk (0,0,0)"), HasSubstr("stays: ")),
                    AllOf(HasSubstr("level 4 chunk (0,0,0)"), HasSubstr("made again")),
                    AllOf(HasSubstr("cell_min"), HasSubstr("stays: the voxels"))));
    EXPECT_THAT(differences(whole, filesIn(path)),
                ElementsAre("0/c/0/0/0", "1/c/0/0/0", "2/c/0/0/0", "stats/cell_min/c/0/0/0"));
}

TEST_F(ValidatedStore, NoByteCanChangeUnnoticed) {
    std::mt19937 random(31);
    std::vector<std::string> names;
    for (const auto& [name, text] : whole)
        if (name.back() != '/')
            names.push_back(name);
    for (int i = 0; i < 80; ++i) {
        const std::string& name = names[random() % names.size()];
        const std::size_t at = random() % whole.at(name).size();
        const char mask = static_cast<char>(1 + random() % 255);
        flipByte(path / name, at, mask);
        const ValidateReport report = validate(path);
        ASSERT_FALSE(report.lines.empty()) << name << " byte " << at << " xor " << int(mask);
        EXPECT_EQ(report.lines.size(), 1u) << testing::PrintToString(report.lines);
        // The group's document at its own level, and every file of the part for statistics.
        const std::string part = name.starts_with("stats/") ? name.substr(0, name.find('/', 6)) : name;
        EXPECT_THAT(report.lines[0], HasSubstr("v.zarr/" + part)) << name << " byte " << at;
        const ValidateReport repaired = validate(path, true);
        if (name != "zarr.json" && name != "0/c/0/0/0") {
            EXPECT_EQ(repaired.mended, 1u) << testing::PrintToString(repaired.lines);
            EXPECT_THAT(validate(path).lines, IsEmpty()) << name;
        }
        if (name.starts_with("stats/histograms")) {
            restore();
        } else if (name != "zarr.json" && name != "0/c/0/0/0") {
            EXPECT_THAT(differences(whole, filesIn(path)), IsEmpty()) << name << " byte " << at;
        }
        setFileText(path / name, whole.at(name));
    }
}

TEST_F(ValidatedStore, StatisticsWhoseChecksumsAreRightAreFoundOutByComputingThem) {
    std::vector<float> cells(cellCount(cellGrid({70, 47, 65})), 5.0f);
    const glm::ivec3 grid = cellGrid({70, 47, 65});
    const ArraySpec spec = {"float32", 4, grid, glm::min(grid, glm::ivec3(64, 64, 16)), 0};
    fs::remove_all(path / "stats/cell_min/c");
    for (int layer = 0; layer < spec.layers(); ++layer)
        writeArrayLayer(
            path / "stats/cell_min", spec, layer,
            std::as_bytes(std::span(cells)).first(cellCount({grid.x, grid.y, std::min(16, grid.z)}) * 4));
    Json group = parseJson(whole.at("stats/zarr.json"), "");
    group["attributes"]["tessera"]["arrays"]["cell_min"] = crc32c(std::as_bytes(std::span(cells)));
    seal(group);
    setFileText(path / "stats/zarr.json", storedText(group));
    EXPECT_THAT(validate(path).lines, IsEmpty());
    const ValidateReport report = validate(path, false, true);
    ASSERT_EQ(report.lines.size(), 2u) << testing::PrintToString(report.lines);
    EXPECT_THAT(report.lines[0], AllOf(HasSubstr("stats/cell_min"), HasSubstr("what the voxels give")));
    EXPECT_THAT(report.lines[1], HasSubstr("stats/zarr.json"));
    EXPECT_EQ(validate(path, true, true).mended, 2u);
    EXPECT_THAT(differences(whole, filesIn(path)), IsEmpty());
}

TEST_F(ValidatedStore, LocalHistogramsOfOtherVoxelsAreFoundOutByMakingThemAgain) {
    EXPECT_THAT(validate(path, false, true).notes, IsEmpty());
    HashSource other(plainInfo({70, 47, 65}, ValueType::i16),
                     [](int x, int y, int z) { return x * y + 3 * z; });
    import(scratch / "other.zarr", other);
    {
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(path, ram), voxels(scratch / "other.zarr", ram);
        LocalHistogramSettings settings;
        settings.radiusMm = 4;
        settings.representatives = 64;
        fs::remove_all(path / "stats/histograms");
        localHistogramsOf(store, voxels, 0, loadStatistics(voxels, ram, 1), settings, ram, 1);
    }
    EXPECT_THAT(validate(path).lines, IsEmpty());
    const ValidateReport report = validate(path, false, true);
    ASSERT_EQ(report.lines.size(), 1u) << testing::PrintToString(report.lines);
    EXPECT_THAT(report.lines[0], AllOf(HasSubstr("stats/histograms"), HasSubstr("what the voxels give")));
    EXPECT_EQ(validate(path, true, true).mended, 1u);
    EXPECT_FALSE(fs::exists(path / "stats/histograms"));
}

TEST_F(ValidatedStore, ALinkIsNeitherFollowedNorReplaced) {
    fs::rename(path / "1/c/0/0/0", scratch / "elsewhere");
    flipByte(scratch / "elsewhere", 50);
    const std::string elsewhere = fileText(scratch / "elsewhere");
    fs::create_symlink(scratch / "elsewhere", path / "1/c/0/0/0");
    const ValidateReport report = validate(path, true);
    ASSERT_EQ(report.lines.size(), 1u);
    EXPECT_THAT(report.lines[0],
                AllOf(HasSubstr("a symbolic link"), HasSubstr("stays: 1/c/0/0/0 is a symbolic")));
    EXPECT_EQ(fileText(scratch / "elsewhere"), elsewhere);
    EXPECT_TRUE(fs::is_symlink(path / "1/c/0/0/0"));
}

TEST_F(ValidatedStore, AStoreThatIsBeingWrittenIsLeftAlone) {
    const LockTry writer = tryLock(path, LockKind::exclusive);
    ASSERT_TRUE(writer.locked);
    for (const bool repair : {false, true})
        EXPECT_THAT([&] { validate(path, repair); },
                    ThrowsMessage<InputError>(AllOf(HasSubstr("v.zarr"), HasSubstr("being written"))));
}

TEST_F(ValidatedStore, ResultsDependNeitherOnThreadsNorOnMemory) {
    flipByte(path / "1/c/0/0/0", 50);
    flipByte(path / "0/c/0/0/0", 50);
    const auto lines = validate(path).lines;
    EXPECT_EQ(lines.size(), 2u);
    EXPECT_EQ(validate(path, false, false, kPlenty, 1).lines, lines);
    EXPECT_EQ(validate(path, false, false, kPlenty, 7).lines, lines);
    EXPECT_EQ(validate(path, false, false, 3u << 20).lines, lines);
    EXPECT_THAT([&] { validate(path, false, false, 100000); }, ThrowsMessage<InputError>(HasSubstr("--ram")));
}

TEST(Validate, VolumesOfEveryTypeAreWhole) {
    ScratchFolder scratch;
    for (const ValueType type : {ValueType::u8, ValueType::i16, ValueType::u16, ValueType::f32})
        for (const glm::ivec3& extent : {glm::ivec3(1, 1, 1), glm::ivec3(65, 3, 129)}) {
            HashSource source(plainInfo(extent, type));
            import(scratch / "v.zarr", source, true);
            EXPECT_THAT(validate(scratch / "v.zarr", false, true).lines, IsEmpty()) << name(type);
        }
    // Nothing but fill: no shard at all.
    HashSource source(plainInfo({40, 40, 40}, ValueType::u8), [](int, int, int) { return 0; });
    import(scratch / "v.zarr", source, true);
    EXPECT_THAT(validate(scratch / "v.zarr").lines, IsEmpty());
    for (const char* file : {"0/c/0/0/0", "2/c/0/0/0"}) {
        fs::create_directories((scratch / "v.zarr" / file).parent_path());
        setFileText(scratch / "v.zarr" / file, "stray");
    }
    const ValidateReport report = validate(scratch / "v.zarr", true);
    ASSERT_EQ(report.lines.size(), 2u);
    EXPECT_THAT(report.lines[0], AllOf(HasSubstr("0/c/0/0/0"), HasSubstr("all is fill"), HasSubstr("stays")));
    EXPECT_THAT(report.lines[1], AllOf(HasSubstr("2/c/0/0/0"), HasSubstr("made again")));
    EXPECT_EQ(validate(scratch / "v.zarr").lines.size(), 1u);
}

// Three shards of level 0 along each axis in turn, two of level 1: each by its own name, with chunks by their
// places in the level; what is damaged in one leaves the others alone.
TEST(Validate, EveryShardIsCheckedAndMendedByItself) {
    for (int axis = 0; axis < 3; ++axis) {
        ScratchFolder scratch;
        const fs::path path = scratch / "v.zarr";
        glm::ivec3 extent(33, 34, 35);
        extent[axis] = 1100;
        HashSource source(plainInfo(extent, ValueType::u8));
        import(path, source);
        const Files whole = filesIn(path);
        const ValidateReport report = validate(path);
        EXPECT_THAT(report.lines, IsEmpty());
        EXPECT_EQ(report.shards, 3u + 2 + 4);
        EXPECT_EQ(report.chunks, 35u * 4 + 18 + 9 + 5 + 3 + 2) << "of 1100, 550, 275, 138, 69 and 35 voxels";
        const auto nameOf = [&](int level, int shard) {
            glm::ivec3 at(0);
            at[axis] = shard;
            return shardPath(level, at);
        };
        // The second chunk along the axis of the second shard: number 17 of the level.
        glm::ivec3 place(0);
        place[axis] = 17;
        for (const int level : {0, 1}) {
            const std::string shard = nameOf(level, 1);
            const std::string text = whole.at(shard);
            const glm::ivec3 chunks = glm::min(ceilDiv(levelExtent(extent, level), kChunkExtent),
                                               glm::ivec3(kShardExtent / kChunkExtent));
            glm::ivec3 inside(0);
            inside[axis] = 1;
            const ShardEntry entry = indexOf(text, cellCount(chunks))[linearIndex(inside, chunks)];
            flipByte(path / shard, entry.offset + entry.bytes / 2);
            const ValidateReport found = validate(path, true);
            ASSERT_EQ(found.lines.size(), 1u) << testing::PrintToString(found.lines);
            EXPECT_THAT(found.lines[0], AllOf(HasSubstr("v.zarr/" + shard),
                                              HasSubstr(describe({level, place.x, place.y, place.z})),
                                              HasSubstr(level == 0 ? "stays: " : "made again")));
            EXPECT_EQ(differences(whole, filesIn(path)),
                      level == 0 ? std::vector{shard} : std::vector<std::string>());
            setFileText(path / shard, text);
        }
        fs::remove(path / nameOf(1, 1)); // made anew, whole, from level 0
        const ValidateReport found = validate(path, true);
        ASSERT_EQ(found.lines.size(), 1u) << testing::PrintToString(found.lines);
        EXPECT_THAT(found.lines[0], AllOf(HasSubstr(nameOf(1, 1)), HasSubstr("made again")));
        EXPECT_THAT(differences(whole, filesIn(path)), IsEmpty());
    }
}

// The range that the metadata tell is that of level 0, whose padding counts for nothing.
TEST(Validate, TheRangeOfLevel0IsThatOfItsVoxels) {
    ScratchFolder scratch;
    VolumeInfo info = plainInfo({37, 35, 34}, ValueType::i16);
    info.fillStored = -2000; // beyond the voxels' range
    HashSource source(info, [](int x, int y, int z) {
        return x == 36 && y == 0 && z == 5 ? -701 : x == 3 && y == 34 && z == 33 ? 903 : (x + y + z) % 50;
    });
    import(scratch / "v.zarr", source);
    EXPECT_THAT(validate(scratch / "v.zarr").lines, IsEmpty());
    const std::string text = fileText(scratch / "v.zarr/zarr.json");
    for (const auto& [key, value] :
         {std::pair("lowest", -702), {"lowest", -700}, {"highest", 902}, {"highest", 904}}) {
        Json document = Json::parse(text);
        Json& attributes = document["attributes"];
        attributes["tessera"]["range"][key] = value;
        Json& window =
            attributes["ome"]["omero"]["channels"][0]["window"]; // without a unit that of the range
        const bool isLow = std::string(key) == "lowest";
        window[isLow ? "min" : "max"] = value;
        window[isLow ? "start" : "end"] = static_cast<double>(value);
        seal(document);
        setFileText(scratch / "v.zarr/zarr.json", storedText(document));
        const ValidateReport report = validate(scratch / "v.zarr", true);
        ASSERT_EQ(report.lines.size(), 2u) << testing::PrintToString(report.lines);
        EXPECT_THAT(
            report.lines[0],
            AllOf(HasSubstr("expected the range of level 0, -701 to 903, found "),
                  HasSubstr(isLow ? std::to_string(value) + " to 903" : "-701 to " + std::to_string(value)),
                  HasSubstr("stays: what it says of level 0 is told by an import alone")));
        EXPECT_THAT(report.lines[1], HasSubstr("stats/zarr.json: expected statistics of this store"));
    }
}

TEST(Validate, LevelsThatAreNotMeansAreFoundThoughTheirChecksumsAreRight) {
    ScratchFolder scratch;
    const VolumeInfo info = plainInfo({70, 40, 40}, ValueType::u8);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    PyramidRule rule;
    rule.reduce = [](ValueType type, const glm::ivec3& extent, std::span<const std::byte> in,
                     std::span<std::byte> out, int threads) {
        reduceByTwo(type, extent, in, out, threads);
        if (extent.x == 70 && extent.z == 32)
            out[34] =
                static_cast<std::byte>(static_cast<unsigned>(out[34]) + 1); // of chunk (1,0,0) of level 1
    };
    HashSource source(info);
    {
        StoreWriter writer(scratch / "v.zarr", info, ram, 1, false, rule);
        while (const int slices = writer.nextSlices()) {
            source.readSlices(slices, writer.next());
            writer.push();
        }
        writer.finish(info);
        buildStatistics(StoreReader(writer.folder(), ram), writer.folder(), ram, 1);
        writer.commit(false);
    }
    for (const bool repair : {false, true}) {
        const ValidateReport report = validate(scratch / "v.zarr", repair);
        ASSERT_EQ(report.lines.size(), 1u) << testing::PrintToString(report.lines);
        EXPECT_THAT(report.lines[0],
                    AllOf(HasSubstr("level 1 chunk (1,0,0)"), HasSubstr("what level 0 gives")));
        EXPECT_EQ(report.mended, 0u);
    }
}

TEST(Validate, LevelsOfLabelsAreMadeAgainByTheirOwnRule) {
    ScratchFolder scratch;
    const glm::ivec3 extent(70, 47, 40);
    VolumeInfo scan = plainInfo(extent, ValueType::u16);
    LabelFile file = fileOf({HeldLayer(scan, blobs(extent, {3, 7, 9}, 5, 40))});
    MemoryBudget ram("RAM", "--ram", kPlenty);
    LabelImportOptions options;
    options.threads = 1;
    importLabels(file, scan, scratch / "l.zarr", ram, options);
    const Files whole = filesIn(scratch / "l.zarr");
    EXPECT_THAT(validate(scratch / "l.zarr").lines, IsEmpty());
    for (int level = 1; level < kLevelCount; ++level)
        flipByte(scratch / "l.zarr" / (std::to_string(level) + "/c/0/0/0"), 20);
    EXPECT_EQ(validate(scratch / "l.zarr").faults, 5u);
    EXPECT_EQ(validate(scratch / "l.zarr", true).mended, 5u);
    EXPECT_THAT(differences(whole, filesIn(scratch / "l.zarr")), IsEmpty());
    flipByte(scratch / "l.zarr/sets/set/c/0/0/0", 40);
    const ValidateReport report = validate(scratch / "l.zarr", true);
    ASSERT_EQ(report.lines.size(), 1u);
    EXPECT_THAT(report.lines[0], HasSubstr("sets/set"));
    EXPECT_EQ(report.mended, 0u);
}

TEST(Validate, CellsOfOtherLabelsAreFoundOutByMakingThemAgain) {
    ScratchFolder scratch;
    const glm::ivec3 extent(70, 47, 40);
    VolumeInfo scan = plainInfo(extent, ValueType::u16);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    LabelImportOptions options;
    options.threads = 1;
    for (const auto& [name, seed] : {std::pair{"l.zarr", 5}, {"other.zarr", 6}}) {
        LabelFile file = fileOf({HeldLayer(scan, blobs(extent, {3, 7, 9}, seed, 40))});
        importLabels(file, scan, scratch / name, ram, options);
    }
    const fs::path path = scratch / "l.zarr";
    const ValidateReport whole = validate(path, false, true);
    EXPECT_THAT(whole.lines, IsEmpty());
    EXPECT_THAT(whole.notes, IsEmpty());
    const std::string hash = StoreReader(path, ram).contentHash();
    fs::remove_all(path / "sets");
    fs::copy(scratch / "other.zarr/sets", path / "sets", fs::copy_options::recursive);
    Json group = parseJson(fileText(path / "sets/zarr.json"), "");
    group["attributes"]["tessera"]["store"] = hash;
    seal(group);
    setFileText(path / "sets/zarr.json", storedText(group));
    EXPECT_THAT(validate(path).lines, IsEmpty());
    const ValidateReport report = validate(path, true, true);
    ASSERT_EQ(report.lines.size(), 1u) << testing::PrintToString(report.lines);
    EXPECT_THAT(report.lines[0], AllOf(HasSubstr("sets/"), HasSubstr("what the voxels give")));
    EXPECT_EQ(report.mended, 0u);
}

TEST(Validate, WhatIsNoStoreIsRefused) {
    ScratchFolder scratch;
    EXPECT_THROW(validate(scratch / "nothing"), InputError);
    fs::create_directory(scratch / "photos");
    EXPECT_THAT([&] { validate(scratch / "photos"); },
                ThrowsMessage<InputError>(HasSubstr("expected a store of Tessera")));
    setFileText(scratch / "photos/zarr.json", R"({"zarr_format": 3, "node_type": "group"})");
    EXPECT_THAT([&] { validate(scratch / "photos", true); },
                ThrowsMessage<InputError>(HasSubstr("another program")));
}

} // namespace
} // namespace tessera

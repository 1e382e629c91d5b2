// tests/viewer/input/file_part_input_test.cpp: the store that a command gets for a level of a file or a box
// of it: the cache of imports, what it has room for, and what the store says.
#include "bricking/store/store_reader.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "viewer/cli/input/file_level.h"
#include "viewer/cli/input/import_cache.h"
#include "viewer/cli/input/volume_input.h"

#include <cstdlib>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class FilePartInput : public ::testing::Test {
  protected:
    /// An image of OME-Zarr 0.4 with levels of 16, 8 and 4 voxels along each axis.
    FilePartInput() {
        ::setenv("XDG_CACHE_HOME", (folder / "cache").c_str(), 1);
        json datasets = json::array(), axes = json::array();
        for (const char* const axis : {"z", "y", "x"})
            axes.push_back(json{{"name", axis}, {"type", "space"}, {"unit", "millimeter"}});
        for (int level = 0; level < 3; ++level) {
            const int side = 16 >> level;
            const double mm = 1 << level, first = (mm - 1) / 2;
            const std::string name = std::to_string(level);
            const json scale = {{"type", "scale"}, {"scale", {mm, mm, mm}}},
                       shift = {{"type", "translation"}, {"translation", {first, first, first}}};
            datasets.push_back(
                json{{"path", name}, {"coordinateTransformations", json::array({scale, shift})}});
            fs::create_directories(path / name);
            std::ofstream(path / name / ".zarray") << json{
                {"zarr_format", 2}, {"shape", {side, side, side}}, {"chunks", {side, side, side}},
                {"dtype", "|u1"},   {"compressor", nullptr},       {"fill_value", 0},
                {"order", "C"},     {"filters", nullptr}}.dump();
            std::string voxels;
            for (int n = 0; n < side * side * side; ++n)
                voxels += static_cast<char>(1 + n * 37 % 199);
            std::ofstream(path / name / "0.0.0", std::ios::binary) << voxels;
        }
        std::ofstream(path / ".zgroup") << R"({"zarr_format":2})";
        const json scales = {{"version", "0.4"}, {"axes", axes}, {"datasets", datasets}};
        std::ofstream(path / ".zattrs") << json{{"multiscales", json::array({scales})}}.dump();
    }
    ~FilePartInput() override {
        ::unsetenv("XDG_CACHE_HOME");
        ::unsetenv("TESSERA_CACHE_SIZE");
    }
    static InputOptions part(std::optional<int> level, std::optional<FileBox> box = {}) {
        InputOptions options;
        options.fileLevel = level;
        options.fileBox = box;
        return options;
    }
    VolumeInfo imported(const InputOptions& options) {
        CommonOptions common;
        common.progress = std::make_shared<Progress>(Verbosity::normal, false);
        ::testing::internal::CaptureStderr();
        try {
            store = storeFor(path, options, ram, common);
        } catch (...) {
            ::testing::internal::GetCapturedStderr();
            throw;
        }
        said = ::testing::internal::GetCapturedStderr();
        return StoreReader(store, ram).info();
    }
    const ScratchFolder folder;
    const fs::path path = folder / "a.zarr";
    MemoryBudget ram{"RAM", "--ram", std::size_t{1} << 28};
    fs::path store;
    std::string said;
};

TEST_F(FilePartInput, PartsAreImportsOfTheirOwnAndSayWhichTheyAre) {
    EXPECT_FALSE(imported({}).filePart);
    const fs::path whole = store;
    EXPECT_TRUE(isCached(path, InputOptions().key()));
    EXPECT_FALSE(isCached(path, part(1).key()));
    const VolumeInfo level = imported(part(1));
    EXPECT_NE(store, whole);
    ASSERT_TRUE(level.filePart);
    EXPECT_EQ(*level.filePart, (FilePart{1, glm::ivec3(16), glm::ivec3(8), {glm::ivec3(0), glm::ivec3(8)}}));
    EXPECT_EQ(level.spacingMm(), glm::dvec3(2));
    const FileBox one{{1, 0, 2}, {5, 8, 7}}, other{{2, 0, 2}, {6, 8, 7}};
    const VolumeInfo box = imported(part(1, one));
    const fs::path ofBox = store;
    EXPECT_EQ(box.extentVoxels, glm::ivec3(4, 8, 5));
    EXPECT_EQ(box.filePart->box, one);
    EXPECT_THAT(
        sayFilePart(*box.filePart),
        HasSubstr("level 1 of its file, 8 x 8 x 8 voxels (the finest has 16 x 16 x 16), box 1,5,0,8,2,7"));
    EXPECT_EQ(imported(part(1, other)).filePart->box, other);
    EXPECT_NE(store, ofBox) << "imports do not mix";
    imported(part(1, one));
    EXPECT_EQ(store, ofBox);
    EXPECT_EQ(imported(part(0)).filePart, std::nullopt);
    EXPECT_EQ(store, whole) << "level 0 is the finest";
}

TEST_F(FilePartInput, WhatTheCacheHasNoRoomForIsTakenCoarser) {
    ::setenv("TESSERA_CACHE_SIZE", "1KiB", 1);
    EXPECT_EQ(imported({}).filePart->level, 1);
    EXPECT_THAT(said,
                AllOf(HasSubstr("16 x 16 x 16"), HasSubstr("8 x 8 x 8"), HasSubstr("level 1 is taken")));
    EXPECT_EQ(imported(part(SourceChoice::kAutoLevel)).filePart->level, 1);
    EXPECT_FALSE(imported(part(0)).filePart) << "asked for";
    EXPECT_EQ(imported(part({}, FileBox{{0, 0, 0}, {2, 2, 2}})).filePart->level, 0);
    EXPECT_THROW(imported(part(SourceChoice::kAutoLevel, FileBox{{0, 0, 0}, {2, 2, 2}})), InputError);
    CommonOptions common;
    common.quiet = true;
    EXPECT_FALSE(withFileLevel(path, {}, common, UnsaidLevel::finest).fileLevel) << "tessera import";
    ::setenv("TESSERA_CACHE_SIZE", "1MiB", 1);
    EXPECT_FALSE(imported({}).filePart) << "there is room";
}

// Spacing is said of a level that is named: of none is another taken by itself.
TEST_F(FilePartInput, SpacingIsOfTheLevelThatIsNamed) {
    ::setenv("TESSERA_CACHE_SIZE", "1KiB", 1);
    InputOptions options;
    options.spacingMm = glm::dvec3(0.5);
    CommonOptions common;
    EXPECT_FALSE(withFileLevel(path, options, common, UnsaidLevel::fits).fileLevel);
    EXPECT_EQ(levelToBeginWith(path, options, 512), std::nullopt);
    options.fileLevel = SourceChoice::kAutoLevel;
    EXPECT_THROW(withFileLevel(path, options, common, UnsaidLevel::fits), InputError);
    options.fileLevel = 1;
    EXPECT_EQ(withFileLevel(path, options, common, UnsaidLevel::fits).fileLevel, 1);
}

// The finest level opens though a coarse one is not there.
TEST_F(FilePartInput, ALevelThatIsMissingClosesNoFile) {
    EXPECT_EQ(levelToBeginWith(path, {}, 100), 2);
    fs::remove_all(path / "2");
    ASSERT_FALSE(fs::exists(path / "2"));
    EXPECT_EQ(levelToBeginWith(path, {}, 100), std::nullopt);
    EXPECT_EQ(imported({}).extentVoxels, glm::ivec3(16));
}

TEST_F(FilePartInput, ACoarseLevelComesFirstWhereTheMeantOneIsNotThere) {
    EXPECT_EQ(levelToBeginWith(path, {}, 512), 1);
    EXPECT_EQ(levelToBeginWith(path, {}, 100), 2);
    EXPECT_EQ(levelToBeginWith(path, {}, 10), std::nullopt) << "none is as small";
    EXPECT_EQ(levelToBeginWith(path, {}, 4096), std::nullopt) << "the finest is";
    EXPECT_EQ(levelToBeginWith(path, part(0), 512), std::nullopt) << "asked for";
    EXPECT_EQ(levelToBeginWith(folder / "nothing", {}, 512), std::nullopt);
    imported({});
    EXPECT_EQ(levelToBeginWith(path, {}, 512), std::nullopt) << "it is in the cache";
}

TEST_F(FilePartInput, TheListingHasTheLevels) {
    const InputListing listing = listInput(path, {});
    ASSERT_EQ(listing.volumes.size(), 1u);
    ASSERT_EQ(listing.volumes[0].levels.size(), 3u);
    EXPECT_EQ(listing.volumes[0].levels[2].extentVoxels, glm::ivec3(4));
    EXPECT_EQ(listing.volumes[0].levelsProblem, "");
    fs::remove(path / "1/.zarray");
    EXPECT_THAT(listInput(path, {}).volumes[0].levelsProblem, HasSubstr("a.zarr/1"));
}

} // namespace
} // namespace tessera::test

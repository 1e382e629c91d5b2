// tests/viewer/window/window_parts_test.cpp: the window's parts without a window: folders as a browser lists
// them, remembered settings, the isosurface that is offered.
#include "core/base/program_folders.h"
#include "viewer/window/folder_listing.h"
#include "viewer/window/function_edits.h"
#include "viewer/window/settings.h"

#include <fstream>
#include <gtest/gtest.h>

namespace tessera {
namespace {

namespace fs = std::filesystem;

TEST(FolderListing, HasWhatCanBeOpened) {
    const ScratchFolder scratch;
    for (const char* const name : {"scan 10", "scan 9", ".hidden", "b.zarr"})
        fs::create_directories(scratch / name);
    for (const char* const name : {"head.nii.gz", "scene.json", "IM0001", "IM0002", ".DS_Store", "Alpha.NII"})
        std::ofstream(scratch / name) << "x";
    const FolderListing listing = listFolder(scratch.path());
    std::vector<std::string> names;
    for (const FolderEntry& entry : listing.entries)
        names.push_back(entry.name);
    EXPECT_EQ(names, (std::vector<std::string>{"scan 9", "scan 10", "b.zarr", "Alpha.NII", "head.nii.gz",
                                               "scene.json"}));
    EXPECT_EQ(listing.entries[2].kind, FolderEntry::Kind::store);
    EXPECT_EQ(listing.otherFiles, 2u);
    EXPECT_EQ(listing.problem, "");
    EXPECT_TRUE(listing.folder.is_absolute());
    EXPECT_NE(listFolder(scratch / "nowhere").problem, "");
    EXPECT_EQ(folderAt(scratch / "nowhere/at/all"), scratch.path());
    EXPECT_EQ(folderAt(scratch / "b.zarr"), scratch.path());
}

TEST(WindowSettings, AreReadAsTheyWereWritten) {
    const ScratchFolder scratch;
    Settings settings;
    settings.windowSize = {1000, 700};
    settings.folder = "/scans";
    settings.opened("/scans/a.nii");
    settings.panels = false;
    EXPECT_EQ(saveSettings(settings, scratch / "window.json"), "");
    const Settings read = loadSettings(scratch / "window.json");
    EXPECT_EQ(read.windowSize, settings.windowSize);
    EXPECT_EQ(read.folder, settings.folder);
    EXPECT_EQ(read.recent, settings.recent);
    EXPECT_EQ(read.panels, false);
}

TEST(HalfOpaqueValue, IsWhereTheFunctionIsHalfAsOpaqueAsItGets) {
    const auto of = [](std::vector<OpacityPoint> points) {
        return halfOpaqueValue(TransferFunction::fromOpacity(std::move(points), {}, 1), -1000, 3000);
    };
    EXPECT_DOUBLE_EQ(of({{100, 0}, {300, 0.8}}), 200);
    EXPECT_DOUBLE_EQ(of({{100, 0}, {200, 0.2}, {300, 0.8}}), 200 + 100.0 / 3);
    EXPECT_DOUBLE_EQ(of({{100, 0.9}, {300, 0.1}}), 100) << "opaque from the first point on";
    EXPECT_DOUBLE_EQ(of({{5000, 0}, {6000, 1}}), 3000) << "within the volume's values";
    EXPECT_DOUBLE_EQ(of({}), 1000) << "of nothing, the middle";
}

} // namespace
} // namespace tessera

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

TEST(WindowSettings, KeepTheLastFilesAndSizesThatFitAScreen) {
    const ScratchFolder scratch;
    Settings settings;
    for (int n = 0; n < 20; ++n)
        settings.opened("/scans/" + std::to_string(n));
    ASSERT_EQ(settings.recent.size(), 12u);
    EXPECT_EQ(settings.recent.front(), "/scans/19");
    EXPECT_EQ(settings.recent.back(), "/scans/8");
    settings.opened("/scans/./x/../12");
    EXPECT_EQ(settings.recent.size(), 12u);
    EXPECT_EQ(settings.recent.front(), "/scans/12");
    const auto read = [&](const std::string& text) {
        std::ofstream(scratch / "w.json") << text;
        return loadSettings(scratch / "w.json");
    };
    EXPECT_EQ(read(R"({"windowSize": [10, 10]})").windowSize, glm::ivec2(320, 240));
    EXPECT_EQ(read(R"({"windowSize": [99999, 99999]})").windowSize, glm::ivec2(16384));
    for (const char* const bad : {R"({"windowSize": [10]})", R"({"windowSize": [10.5, 700]})",
                                  R"({"windowSize": 7})", "[1, 2]", "x"}) {
        EXPECT_EQ(read(bad).windowSize, glm::ivec2(0)) << bad;
        EXPECT_TRUE(read(bad).panels);
    }
    std::string many;
    for (int n = 0; n < 20; ++n)
        many += (n > 0 ? ", \"" : "\"") + std::to_string(n) + "\"";
    const Settings limited = read("{\"recent\": [3, " + many + "]}");
    ASSERT_EQ(limited.recent.size(), 12u);
    EXPECT_EQ(limited.recent.back(), "11");
    EXPECT_EQ(saveSettings(settings, {}), "") << "nowhere";
    EXPECT_NE(saveSettings(settings, scratch / "w.json/below"), "");
    EXPECT_EQ(saveSettings(settings, scratch / "new/folder/w.json"), "");
    EXPECT_EQ(loadSettings(scratch / "new/folder/w.json").recent, settings.recent);
}

TEST(FunctionEdits, MovePointsAndColoursTogether) {
    auto f = TransferFunction::fromOpacity({{100, 0.1}, {300, 0.5}, {500, 0.9}},
                                           {{100, {1, 0, 0}}, {500, {0, 1, 0}}}, 2);
    f.setTissues({{300, 500, Phase{PhaseKind::rayleigh}, {}}});
    EXPECT_EQ(withPointAt(f, 1, 250, 0.7).tissues(), f.tissues());
    EXPECT_EQ(shiftedAndStretched(f, 50, 2).tissues(),
              (std::vector<Tissue>{{350, 750, Phase{PhaseKind::rayleigh}, {}}}));
    const TransferFunction moved = shiftedAndStretched(f, 50, 2);
    const std::vector<double> values = {-50, 350, 750};
    for (std::size_t n = 0; n < 3; ++n) {
        EXPECT_DOUBLE_EQ(moved.opacityPoints()[n].value, values[n]);
        EXPECT_EQ(moved.opacityPoints()[n].opacity, f.opacityPoints()[n].opacity);
    }
    EXPECT_EQ(moved.colour(-50), f.colour(100));
    EXPECT_EQ(moved.colour(750), f.colour(500));
    EXPECT_EQ(moved.referenceLengthMm(), 2);
    EXPECT_EQ(withPointAt(f, 1, 900, 0.7).opacityPoints()[1].value <= 500, true) << "not past its neighbours";
    EXPECT_EQ(withPointAt(f, 1, -900, 0.7).opacityPoints()[1].value >= 100, true);
    EXPECT_EQ(withPointAt(f, 1, 250, 0.7).opacityPoints()[1].value, 250);
    EXPECT_EQ(withPointAt(f, 1, 250, 0.7).opacityPoints()[1].opacity, 0.7);
    EXPECT_EQ(withPointAt(f, 0, -900, 0.7).opacityPoints()[0].value, -900);
    EXPECT_EQ(withPointAt(f, 2, 900, 0.7).opacityPoints()[2].value, 900);
    std::size_t index = 9;
    EXPECT_EQ(withNewPoint(f, 400, 0.2, index).opacityPoints().size(), 4u);
    EXPECT_EQ(index, 2u);
    EXPECT_EQ(withNewPoint(f, -400, 0.2, index).opacityPoints()[0].value, -400);
    EXPECT_EQ(index, 0u);
    TransferFunction fewer = f;
    for (std::size_t left = 3; left > 1; --left) {
        EXPECT_EQ(fewer.opacityPoints().size(), left);
        fewer = withoutPoint(fewer, 0);
    }
    EXPECT_EQ(withoutPoint(fewer, 0).opacityPoints().size(), 1u) << "the last one stays";
    EXPECT_EQ(fewer.opacityPoints()[0].value, 500);
    EXPECT_EQ(withColourAt(f, 110, {0, 0, 1}, 20).colour(100), glm::dvec3(0, 0, 1)) << "a near point's";
    const TransferFunction another = withColourAt(f, 200, {0, 0, 1}, 20);
    EXPECT_EQ(another.colour(200), glm::dvec3(0, 0, 1));
    EXPECT_EQ(another.colour(100), f.colour(100));
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

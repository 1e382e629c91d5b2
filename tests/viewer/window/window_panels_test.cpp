// tests/viewer/window/window_panels_test.cpp: what the panel and the openers draw, ask for and change in the
// scene, step by step, is what is recorded (tests/support/window_record.h).
#include "core/base/program_folders.h"
#include "core/scene/scene_presets.h"
#include "tests/support/window_record.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

TEST(WindowDrawn, PanelOfViewAndMode) {
    PanelWindow w;
    w.step("open", [] {});
    for (const char* const side : {"anterior", "posterior", "left", "right", "superior", "inferior"})
        w.clicked(side);
    w.clicked("parallel");
    w.clicked("perspective");
    w.dragged("30 deg", 40);
    w.clicked("fly (W A S D");
    w.clicked("show all (R)");
    w.clicked("as opened");
    w.chosen("composite", "maximum");
    w.dragged("1100", 20);
    w.chosen("maximum", "slice");
    w.chosen("axial", "sagittal");
    w.dragged("0.0 mm", 30);
    w.dragged("plane alone", 40);
    w.chosen("average", "minimum");
    w.chosen("slice", "isosurface");
    w.clicked("add isosurface");
    w.dragged("opacity 1.00@2", -30);
    w.dragged("480@2", 25);
    w.clicked("remove");
    w.clicked("remove");
    w.clicked("beside the volume (X)");
    w.chosen("all three", "coronal");
    w.chosen("abdomen", "lung");
    w.dragged("1500", 10);
    w.dragged("-600", -10);
    compareWithRecord(w, "panel-view-mode");
}

TEST(WindowDrawn, PanelOfCutsLightAndSaving) {
    PanelWindow w;
    w.step("open", [] {});
    w.clicked("Save");
    w.chosen("400 x 300, as shown", "1600 x 1200");
    w.chosen("black", "transparent");
    w.clicked("scale bar in the picture");
    w.clicked("colour legend");
    w.clicked("in the picture");
    w.clicked("save picture (F12)");
    w.clicked("hide the table, if found");
    w.clicked("crop box (B)");
    w.dragged("40.0 mm", -40);
    w.dragged("0.0 mm@2", 20);
    w.clicked("keep outside");
    w.clicked("cut by a plane (N)");
    w.clicked("cut by a plane (N)");
    w.dragged("0.0 mm@0", 30);
    w.clicked("flip@2");
    w.clicked("face me@2");
    w.clicked("remove");
    w.clicked("undo (Ctrl Z)");
    w.clicked("redo (Ctrl Y)");
    w.clicked("remove all cuts");
    w.clicked("inside");
    w.clicked("outside (K)");
    w.clicked("distance (M)");
    w.clicked("angle (G)");
    w.clicked("circle (C)");
    w.step("three places", [&] {
        for (const glm::dvec3 place : {glm::dvec3(0, 0, 0), {10, 0, 0}, {0, 10, 0}})
            w.tools.placed(w.desk, place);
    });
    w.step("its values", [&] { w.viewing.disc = DiscValues{1, 50, 12.5, 3.25, 1, 20}; });
    w.step("an outline", [&] {
        Scene scene = w.desk.scene();
        scene.cuts.scissors.push_back({w.desk.camera(), 1.5, {{0, 0}, {1, 0}, {1, 1}}, Keep::outside});
        w.desk.beginEdit();
        w.desk.setScene(scene, false);
    });
    w.clicked("remove");
    w.clicked("remove");
    w.clicked("shading");
    w.clicked("shading");
    w.dragged("0.20", 50);
    w.dragged("0.80", -50);
    w.dragged("0.25", 30);
    w.chosen("its own@0", lookNames().back());
    w.clicked("paths of light, at rest");
    EXPECT_TRUE(w.viewing.asked.lighting.transport && w.viewing.asked.lighting.environment);
    w.clicked("paths of light, at rest");
    EXPECT_FALSE(w.viewing.asked.lighting.transport || w.viewing.asked.lighting.environment);
    w.clicked("Isosurfaces");
    w.clicked("add isosurface");
    compareWithRecord(w, "panel-cuts-light");
}

TEST(WindowDrawn, PanelOfState) {
    PanelWindow w;
    w.step("open", [] {});
    ViewingState& s = w.viewing.now;
    w.step("bricks", [&] {
        s.ramUsed = 3 << 20, s.ramLimit = 64 << 20, s.gpuUsed = 5 << 20, s.gpuLimit = 100 << 20;
        s.bricksShown = 40, s.bricksAsWanted = 30, s.finestLevel = 1, s.coarsestLevel = 3;
        s.chunksThere = 30, s.chunksMissed = 10, s.movesLeft = 1, s.engine = "an engine";
    });
    w.step("more bricks", [&] {
        s.movesLeft = 7, s.lightIsCoarse = true, s.drawingStill = true, s.noStills = true;
        s.measured = "measured error 0.1", s.coarsestLevel = 0;
    });
    w.step("a round", [&] {
        auto round = std::make_shared<ShownPicture>(*w.viewing.drawn);
        round->stage = Stage::round;
        round->samples = SamplesSeen{16, 64, 0.0123};
        w.viewing.drawn = round;
    });
    w.clicked("colour bricks by level (L)");
    w.step("a failure", [&] { s.problem = "a part cannot be read"; });
    w.step("help", [&] { w.desk.showHelp = true; });
    w.step("no panels", [&] { w.desk.showPanels = false; });
    compareWithRecord(w, "panel-state");
}

TEST(WindowDrawn, EditorOfTheFunction) {
    PanelWindow w;
    w.step("open", [] {});
    const Drawn bars =
        *std::find_if(w.drawn.begin(), w.drawn.end(), [](const Drawn& d) { return d.columns > 0; });
    const glm::dvec2 corner(bars.left, w.placeOf("its own").y + 13);
    const auto onCurve = [&](double value, double opacity) { // as the axis says
        const double width = 330 - 2 * static_cast<double>(ImGui::GetStyle().WindowPadding.x);
        return glm::dvec2(std::round(8 + (value + 1000) / 3000 * width),
                          std::round(corner.y + (1 - std::sqrt(opacity)) * 150));
    };
    w.step(
        "look", [&] { w.moveTo(onCurve(800, 0.5)), w.frame(), w.frame(); }, false);
    w.step("drag a point", [&] { w.drag(onCurve(300, 0.3), onCurve(500, 0.6)); });
    w.step("a new point", [&] { w.click(onCurve(1700, 0.25)); });
    w.step("a new point is dragged", [&] { w.drag(onCurve(-600, 0.1), onCurve(-500, 0.4)); });
    w.step("without a point", [&] { w.click(onCurve(1200, 0.8), 1); });
    w.step("a point's colour", [&] {
        w.click(onCurve(500, 0.6));
        w.click(onCurve(500, 0.6));
        w.frame();
    });
    w.dragged("R:231", -60);
    w.step("the colour is there", [&] { w.click({900, 2900}); });
    w.step("zoom", [&] {
        ImGui::GetIO().KeyCtrl = true;
        w.wheel(onCurve(500, 0.9), 3);
        ImGui::GetIO().KeyCtrl = false;
    });
    w.clicked("all values");
    w.clicked("undo");
    w.chosen("its own", "bone-1");
    w.step("a picked value", [&] { w.viewing.answer = PickedPlace{5, true, {1, 2, 3}, {1, 2, 3}, 250, 0}; });
    w.clicked("save as mine, import, export");
    compareWithRecord(w, "function-editor");
}

/// The editor edits opacity by value; that there is one by gradient it says.
TEST(WindowPanels, TheEditorNamesOpacityByGradient) {
    PanelWindow w;
    w.rest();
    for (const std::size_t points : {0, 1, 2}) {
        Scene scene = w.desk.scene();
        auto function = std::get<TransferFunction>(scene.volumes[0].transferFunction);
        std::vector<GradientPoint> factors;
        for (std::size_t n = 0; n < points; ++n)
            factors.push_back({10.0 * static_cast<double>(n), 0.5});
        function.setGradientOpacity(GradientOpacity::fromPoints(factors));
        scene.volumes[0].transferFunction = function;
        w.desk.setScene(scene, false);
        w.rest();
        EXPECT_EQ(w.shows("and gradient opacity, " + std::to_string(points) + " points"), points > 0);
        EXPECT_EQ(w.shows("gradient opacity"), points > 0);
    }
}

TEST(WindowDrawn, Openers) {
    HeadlessWindow w({900, 600}, {{kPanel, 0}, {568, 600}, 1});
    ScratchFolder folder;
    for (const char* const name : {"a", "b.zarr"})
        std::filesystem::create_directories(folder / "scans" / name);
    std::ofstream(folder / "scans/head.nii") << "x";
    std::ofstream(folder / "scans/slice 1") << "x";
    ::setenv("HOME", folder.path().c_str(), 1);
    w.settings.folder = folder / "scans";
    w.settings.recent = {"/scans/one.zarr", "/scans/two.zarr", "/3", "/4", "/5", "/6", "/7"};
    w.records = [&](const Drawn& d) { return d.words.find(folder.path().string().substr(0, 6)) != 0; };
    w.step("nothing is open", [] {});
    w.step("recent", [&] { w.clickOn("two.zarr"); });
    w.step("a store", [&] { w.clickOn("b.zarr"); });
    w.step("the folder", [&] { w.clickOn("open this folder (1 file)"); });
    w.step("into a folder", [&] { w.clickOn("a/"); });
    EXPECT_EQ(w.settings.folder, folder / "scans/a") << "it begins there the next time";
    w.step("up", [&] { w.clickOn("up"); });
    w.step("home", [&] { w.clickOn("home"); });
    w.step("a path", [&] {
        w.clickOn("file or folder");
        w.type("/x/y.nii");
        w.clickOn("open");
    });
    w.step("failed", [&] {
        w.viewing.now.kind = ViewingState::Kind::failed, w.viewing.now.what = "that is no volume";
    });
    w.step("opening", [&] {
        w.viewing.now.kind = ViewingState::Kind::opening, w.viewing.now.what = "reading",
        w.viewing.now.share = 0.4;
    });
    w.step("a choice", [&] {
        auto offers = std::make_shared<VolumeOffers>();
        offers->path = "/scans/patient";
        offers->passedOver = "2 reports";
        offers->offers = {
            {"/scans/patient", {2, 0, false, false}, "series 2, CT", "7 slices", "", {}},
            {"/scans/patient", {3, 0, true, false}, "series 3, MR", "1 slice", "one slice only", {}},
            {"/scans/patient", {4, 0, false, true}, "series 4, CT", "9 slices", "", {"0 %", "50 %"}}};
        w.viewing.offered = offers;
        w.viewing.now.kind = ViewingState::Kind::choosing;
        w.viewing.thumbnails = {
            std::make_shared<Thumbnail>(Thumbnail{{40, 30}, std::vector<std::uint32_t>(1200)})};
    });
    w.step("the first", [&] { w.clickOn("series 2, CT"); });
    w.step("none that has a problem", [&] { w.clickOn("series 3, MR"); });
    w.step("a phase", [&] { w.clickOn("2: 50 %"); });
    compareWithRecord(w, "openers");
}

// A phase is opened when the slider is let go.
TEST(WindowDrawn, PhasesHaveASlider) {
    PanelWindow w;
    w.frame();
    EXPECT_FALSE(w.shows("phase"));
    auto seen = std::make_shared<VolumeSeen>(*w.viewing.seen);
    seen->phases = {"0 %", "50 %", "75 %"};
    seen->phase = 2;
    w.viewing.seen = seen;
    w.frame(), w.frame();
    ASSERT_TRUE(w.shows("2 of 3: 50 %"));
    w.viewing.said.clear();
    const auto opened = [&] {
        return std::ranges::count_if(w.viewing.said, [](const std::string& said) {
            return said.find("in the same view") != std::string::npos;
        });
    };
    const glm::dvec2 at = w.placeOf("2 of 3: 50 %");
    w.moveTo(at);
    w.button(0, true);
    for (int n = 1; n <= 6; ++n)
        w.moveTo(at + glm::dvec2(25.0 * n, 0));
    w.frame();
    EXPECT_TRUE(w.shows("3 of 3: 75 %"));
    EXPECT_EQ(opened(), 0);
    w.button(0, false);
    w.frame();
    ASSERT_EQ(opened(), 1);
    EXPECT_NE(std::ranges::find_if(w.viewing.said,
                                   [](const std::string& said) {
                                       return said.find("phase 3, in the same view") != std::string::npos;
                                   }),
              w.viewing.said.end());
}

} // namespace
} // namespace tessera::test

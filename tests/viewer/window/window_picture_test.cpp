// tests/viewer/window/window_picture_test.cpp: what a hand does on the picture and the planes, and what is
// drawn over them, is what is recorded (tests/support/window_record.h).
#include "core/scene/scene_presets.h"
#include "tests/support/window_record.h"
#include "viewer/session/view_geometry.h"

#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

TEST(WindowDrawn, HandOnThePicture) {
    PictureWindow w;
    w.desk.showSlices = false;
    w.step("open", [] {});
    const glm::dvec2 at(300, 200), to(340, 170);
    w.step("orbit", [&] { w.drag(at, to); });
    w.step("zoom", [&] { w.drag(at, to, 1); });
    w.step("pan", [&] { w.drag(at, to, 2); });
    w.step("pan with Shift", [&] { w.keyed(&ImGuiIO::KeyShift, [&] { w.drag(at, to); }); });
    w.step("roll", [&] { w.keyed(&ImGuiIO::KeyCtrl, [&] { w.drag(at, to); }); });
    w.step("window", [&] { w.keyed(&ImGuiIO::KeyAlt, [&] { w.drag(at, to); }); });
    w.step("wheel", [&] { w.wheel(at, 2); });
    w.step("outside", [&] { w.drag({50, 50}, {80, 80}), w.wheel({750, 90}, 2); });
    w.step("look about in flight", [&] {
        w.desk.flying = true;
        w.drag(at, to);
        w.desk.flying = false;
    });
    for (const char key : {'1', '3', '6', 'R', 'P', 'P', 'F', 'F', 'Q'})
        w.step(std::string("key ") + key, [&] { w.hand.press(w.desk, key, false, false); });
    w.viewing.answer = PickedPlace{0, true, {5, 6, 7}, {25, 30, 33}, 123.4, 2};
    w.step("centre", [&] {
        w.click(at);
        w.click(at);
        w.frame();
        EXPECT_EQ(w.viewing.pickedAt, at - w.area.from);
    });
    w.viewing.answer->hit = false;
    w.step("centre on nothing", [&] {
        w.click(at);
        w.click(at);
        w.frame();
    });
    for (const Stage stage : {Stage::moving, Stage::loading, Stage::whole})
        w.step("stage " + std::to_string(static_cast<int>(stage)), [&] { w.viewing.drawn->stage = stage; });
    ViewingState& s = w.viewing.now;
    w.step("a still is drawn", [&] { s.drawingStill = true; });
    w.step("no stills", [&] { s.drawingStill = false, s.noStills = true; });
    Scene paths = w.desk.scene();
    applyLook("cinematic", paths);
    for (const bool still : {true, false}) // beside no stills
        w.step("paths are drawn", [&] {
            s.drawingStill = still;
            w.desk.setScene(paths, false);
            w.viewing.drawn->stage = Stage::whole;
        });
    w.step("a round", [&] {
        w.viewing.drawn->stage = Stage::round;
        w.viewing.drawn->samples = SamplesSeen{1, 64, {}};
    });
    w.step("another round", [&] { w.viewing.drawn->samples = SamplesSeen{8, 64, 0.0123}; });
    w.step("paths are done", [&] { w.viewing.drawn->stage = Stage::still; });
    w.step("paths are off", [&] {
        Scene off = paths;
        off.lighting = {};
        w.desk.setScene(off, false);
        w.viewing.drawn->samples.reset();
    });
    w.step("loading", [&] { w.viewing.drawn->stage = Stage::loading, s.movesLeft = 1; });
    w.step("loading more", [&] { s.movesLeft = 3; });
    w.step("light", [&] { s.movesLeft = 0, s.lightIsCoarse = true; });
    w.step("damage", [&] { s.damagedChunks = 1; });
    w.step("damages", [&] { s.damagedChunks = 2; });
    w.step("levels", [&] {
        w.desk.showLevels = true;
        s.brickGrid = {2, 2, 1};
        s.levels = std::make_shared<std::vector<std::uint8_t>>(std::vector<std::uint8_t>{0, 1, 3, 200});
        s.finestLevel = 0, s.coarsestLevel = 3, s.bricksShown = 3;
    });
    compareWithRecord(w, "picture-hand");
}

TEST(WindowDrawn, ToolsAndCutsOnThePicture) {
    PictureWindow w;
    w.desk.showSlices = false;
    w.step("open", [] {});
    w.viewing.answer = PickedPlace{0, true, {5, 6, 7}, {25, 30, 33}, 123.4, 0};
    const auto measured = [&](Tools::Tool tool, const std::vector<glm::dvec3>& places) {
        w.tools.take(tool);
        for (std::size_t n = 0; n < places.size(); ++n)
            w.step("place " + std::to_string(n), [&] {
                w.viewing.answer->mm = places[n];
                w.click({200 + 30.0 * static_cast<double>(n), 200});
            });
    };
    measured(Tools::Tool::distance, {{-10, 0, 0}, {10, -5, 20}});
    measured(Tools::Tool::angle, {{-10, 0, -30}, {10, -5, -20}, {15, 0, -40}});
    measured(Tools::Tool::circle, {{-15, 0, 30}, {0, -5, 40}, {15, 0, 35}});
    w.viewing.answer->hit = false;
    w.step("a miss", [&] { w.tools.take(Tools::Tool::distance), w.click({200, 200}); });
    w.tools.stop();
    for (const auto tool : {Tools::Tool::scissorsInside, Tools::Tool::scissorsOutside})
        w.step("scissors", [&] {
            w.tools.take(tool);
            w.moveTo({300, 150});
            w.button(0, true);
            for (const glm::dvec2 p : {glm::dvec2(420, 160), {421, 161}, {430, 300}, {310, 320}})
                w.moveTo(p);
            w.button(0, false);
        });
    w.step("no area", [&] { w.tools.take(Tools::Tool::scissorsInside), w.drag({300, 300}, {303, 300}); });
    w.step("being drawn", [&] {
        w.tools.take(Tools::Tool::scissorsInside);
        w.moveTo({300, 150});
        w.button(0, true);
        w.moveTo({350, 250});
    });
    w.button(0, false);
    w.tools.stop();
    w.desk.update();
    Scene clear = w.desk.scene();
    clear.cuts = {}, clear.measurements = {};
    w.desk.setScene(clear, false);
    w.step("box", [&] { w.cuts.toggleBox(w.desk); });
    const auto handles = [&] { return handlesOfBox(w); };
    ASSERT_EQ(handles().size(), 6u);
    for (std::size_t n = 0; n < 6; ++n)
        w.step("side " + std::to_string(n), [&] {
            const glm::dvec2 from = glm::round(handles()[n]);
            w.drag(from + 3.0, from + glm::round(0.25 * (glm::dvec2(400, 320) - from)) + 3.0);
        });
    w.step("beside the handles", [&] { w.drag(handles()[0] + glm::dvec2(0, 11), handles()[0] + 40.0); });
    w.step("no box", [&] { w.cuts.toggleBox(w.desk); });
    w.step("plane", [&] { w.cuts.addPlane(w.desk); });
    const auto plane = [&] { return handleOfPlane(w); };
    w.step("plane is pushed", [&] { w.drag(plane(), plane() + glm::dvec2(10, 30)); });
    w.step("from the side", [&] { w.desk.setCamera(seenFrom(w.desk.camera(), View::left), false); });
    w.step("plane is pushed along", [&] { w.drag(plane(), plane() + glm::dvec2(-15, 30)); });
    w.step("in parallel", [&] { w.desk.setProjection(Projection::parallel); });
    w.step("plane is pushed in parallel", [&] { w.drag(plane(), plane() + glm::dvec2(25, 3)); });
    w.moveTo(plane());
    w.button(0, true);
    EXPECT_TRUE(w.moves);
    w.button(0, false);
    compareWithRecord(w, "picture-tools");
}

TEST(WindowDrawn, Planes) {
    PictureWindow w;
    w.records = [](const Drawn& d) { return d.left > 650; };
    w.step("open", [] {});
    w.step("drawn", [&] {
        auto shown = std::make_shared<ShownSlices>();
        for (int n = 0; n < 3; ++n) {
            shown->planes[static_cast<std::size_t>(n)].frame.size = {296, 198};
            shown->planes[static_cast<std::size_t>(n)].display.resize(296 * 198);
        }
        shown->wish = w.desk.slices();
        shown->value = 42.5;
        w.viewing.planes = shown;
    });
    w.step("fine", [&] {
        auto shown = std::make_shared<ShownSlices>(*w.viewing.planes);
        shown->fine = true;
        w.viewing.planes = shown;
    });
    for (int n = 0; n < 3; ++n) {
        const glm::dvec2 at(800, 80 + 200 * n);
        w.step("crosshair " + std::to_string(n), [&] { w.drag(at, at + glm::dvec2(20, 10)); });
        w.step("wheel " + std::to_string(n), [&] { w.wheel(at, 2); });
        w.step("window " + std::to_string(n), [&] { w.drag(at, at + glm::dvec2(30, -15), 1); });
    }
    w.step("zoom", [&] { w.keyed(&ImGuiIO::KeyCtrl, [&] { w.wheel({800, 80}, 3); }); });
    w.step("no further out", [&] { w.keyed(&ImGuiIO::KeyCtrl, [&] { w.wheel({800, 80}, -9); }); });
    w.step("measurements", [&] {
        Scene scene = w.desk.scene();
        const glm::dvec3 p = w.desk.slices().placeMm;
        scene.measurements = {
            {MeasurementKind::distance, {p, p + glm::dvec3(10, 5, 0)}},
            {MeasurementKind::distance, {p, p + glm::dvec3(0, 5, 10)}},
            {MeasurementKind::circle, {p, p + glm::dvec3(10, 0, 0), p + glm::dvec3(5, 0.0, 5)}}};
        w.desk.setScene(scene, false);
    });
    w.step("one alone", [&] {
        w.click({800, 300});
        w.click({800, 300});
    });
    w.step("all again", [&] {
        w.click({800, 300});
        w.click({800, 300});
    });
    w.step("border", [&] { w.drag({701, 300}, {601, 300}); });
    EXPECT_NEAR(w.desk.planesShare(), 1 - 501.0 / 898, 1e-6);
    w.step("not the border", [&] { w.drag({706, 300}, {650, 300}), w.drag({696, 300}, {650, 300}); });
    EXPECT_NEAR(w.desk.planesShare(), 1 - 501.0 / 898, 1e-6);
    w.step("a point on a plane", [&] {
        w.tools.take(Tools::Tool::distance);
        w.click({800, 80});
        w.click({830, 80});
    });
    w.step("unknown orientation", [&] {
        auto other = pretendedVolume({600, 600});
        other->info.orientationKnown = false;
        w.viewing.seen = other;
    });
    compareWithRecord(w, "planes");
}

/// What is under the pointer is asked for once it rests.
TEST(WindowPicture, ThePointerRestsBeforeItAsks) {
    PictureWindow w;
    w.desk.showSlices = false;
    w.frame();
    w.moveTo({300, 200});
    w.moveTo({320, 210});
    EXPECT_EQ(w.viewing.picks, 0u);
    EXPECT_TRUE(w.moves) << "it is to be asked again";
    std::this_thread::sleep_for(std::chrono::milliseconds(130));
    w.frame();
    EXPECT_EQ(w.viewing.picks, 1u);
    EXPECT_EQ(w.viewing.pickedAt, glm::dvec2(220, 210));
    w.frame();
    EXPECT_EQ(w.viewing.picks, 1u);
    EXPECT_FALSE(w.moves);
    w.desk.setCamera(w.desk.camera(), false);
    w.frame();
    EXPECT_EQ(w.viewing.picks, 2u) << "of another picture";
}

/// The border is 4 units wide to either side, a unit left of the planes.
TEST(WindowPicture, TheBorderIsAsWideAsAFinger) {
    for (const double x : {696.0, 697.0, 705.0, 706.0}) {
        PictureWindow w;
        w.frame();
        w.drag({x, 300}, {650, 300});
        EXPECT_EQ(w.desk.planesShare() != 0.28, x == 697 || x == 705) << x;
    }
}

/// A second click that is kept down enlarges a plane, and moves no crosshair.
TEST(WindowPicture, ADoubleClickDragsNothing) {
    PictureWindow w;
    w.frame();
    w.click(glm::dvec2(800, 300));
    const glm::dvec3 place = w.desk.slices().placeMm;
    w.button(0, true);
    w.moveTo({830, 330});
    EXPECT_EQ(w.desk.enlargedPlane, 1);
    EXPECT_EQ(w.desk.slices().placeMm, place);
    w.button(0, false);
}

/// A box has a least thickness of half a voxel, and stays in the volume.
TEST(WindowPicture, ABoxStaysABox) {
    PictureWindow w;
    w.desk.showSlices = false;
    w.frame();
    w.cuts.toggleBox(w.desk);
    w.frame();
    const auto grip = [&](bool rightmost) {
        glm::dvec2 found(rightmost ? 0 : 1e9, 0);
        for (const Drawn& d : w.drawn)
            if (std::abs(d.right - d.left - 8) < 0.1f && std::abs(d.bottom - d.top - 8) < 0.1f &&
                ((d.left + 4 > found.x) == rightmost))
                found = {d.left + 4, d.top + 4};
        return glm::round(found);
    };
    w.drag(grip(false), grip(false) + glm::dvec2(280, 0));
    w.button(0, true);
    w.button(0, false);
    const CropBox thin = w.desk.scene().cuts.boxes.at(0);
    EXPECT_EQ(thin.high.x, 40);
    EXPECT_NEAR(thin.low.x, 39.5, 1e-9);
    w.desk.undo();
    w.frame();
    w.moveTo(grip(false));
    w.button(0, true);
    EXPECT_TRUE(w.moves);
    w.moveTo(grip(false) - glm::dvec2(60, 0));
    w.button(0, false);
    EXPECT_EQ(w.desk.scene().cuts.boxes.at(0).low.x, 0) << "not out of the volume";
}

TEST(WindowPicture, OpenersNeedRoom) {
    for (const int height : {63, 64, 100}) {
        HeadlessWindow w({900, 600}, {{kPanel, 0}, {500, height}, 1});
        w.viewing.offered = std::make_shared<VolumeOffers>();
        w.frame();
        w.frame();
        EXPECT_EQ(w.shows("Several volumes"), height >= 64) << height;
    }
}

} // namespace
} // namespace tessera::test

// tests/viewer/window/window_lines_test.cpp: lines through hollow organs in the window: what their panel and
// overlays show, what keys do, and how one flies. Recorded (tests/support/window_record.h), and by time.
#include "core/base/program_folders.h"
#include "tests/support/pretended_path.h"
#include "tests/support/window_record.h"

#include <gtest/gtest.h>

namespace tessera::test {
namespace {

constexpr int kSpaceKey = 32, kEnterKey = 257, kRightKey = 262, kLeftKey = 263, kDownKey = 264, kUpKey = 265,
              kHomeKey = 268;

TEST(WindowDrawn, PanelOfLines) {
    const ScratchFolder folder;
    PanelWindow w;
    w.step("open", [] {});
    w.clicked("Endoscopy");
    w.clicked("tree: one click");
    w.step("a place", [&] { EXPECT_TRUE(w.endoscopy.placed(w.desk, {1, 2, 3})); });
    w.step("it grows", [&] {
        w.viewing.lineNow.searching = true, w.viewing.lineNow.what = "growing", w.viewing.lineNow.share = 0.4;
    });
    w.clicked("stop");
    w.step("a failure", [&] {
        w.viewing.lineNow = {};
        w.viewing.lineNow.number = w.viewing.lines;
        w.viewing.lineNow.problem = "there is no lumen";
    });
    EXPECT_EQ(w.desk.message()->text, "there is no lumen");
    EXPECT_TRUE(w.desk.message()->problem);
    w.clicked("line: click its points");
    w.step("two places", [&] {
        w.endoscopy.placed(w.desk, {1, 2, 3});
        w.endoscopy.placed(w.desk, {4, 5, 6});
    });
    w.clicked("find (Enter)");
    w.step("found", [&] { foundLine(w.viewing, true); });
    w.dragged("-500", 10);
    w.clicked("find again");
    w.step("found again", [&] { foundLine(w.viewing, true); });
    w.clicked("fly (Space)");
    w.clicked("cancel (Esc)");
    w.clicked("look ahead (Home)");
    w.clicked("stop at 30 mm");
    w.dragged("0 mm", 30);
    w.clicked("record keyframe");
    w.dragged("20 mm@0", 5);
    w.dragged("20 mm/s", 20);
    w.dragged("90 deg", 15);
    w.dragged("20 mm@0", -40);
    w.step("another look", [&] { w.endoscopy.press(w.desk, kUpKey, false); });
    w.clicked("record keyframe");

    w.clicked("go@0");
    w.clicked("go");
    w.clicked("remove@0");
    w.clicked("what is seen of the wall");
    w.step("coverage", [&] { foundCoverage(w.viewing); });
    w.clicked("look@2");
    w.clicked("there and back");
    w.clicked("what is seen of the wall");
    w.step("coverage", [&] { foundCoverage(w.viewing); });
    w.clicked("backwards");
    w.clicked("record keyframe");
    w.chosen("branch 0", "branch 1");
    w.clicked("leave");
    const std::string file = folder / "p.json";
    w.endoscopy.save(w.desk, file);
    w.step("another volume", [&] { w.viewing.seen = pretendedVolume({400, 300}); });
    w.step("load", [&] { w.endoscopy.load(w.desk, file); });
    compareWithRecord(w, "panel-lines");
}

TEST(WindowDrawn, LinesOnThePicture) {
    PictureWindow w;
    w.step("open", [] {});
    const auto pressed = [&](const std::string& name, int key, bool shift = false) {
        w.step(name, [&] { w.endoscopy.press(w.desk, key, shift); });
    };
    w.step("found without a question", [&] {
        w.endoscopy.find(w.desk, {{1, 2, 3}}, false);
        foundLine(w.viewing, false);
    });
    w.step("levels", [&] { w.desk.showLevels = true; });
    w.step("no levels", [&] { w.desk.showLevels = false; });
    w.step("coverage", [&] {
        w.endoscopy.measureCoverage(w.desk, false);
        foundCoverage(w.viewing);
    });
    w.step("beside the line", [&] {
        SliceWish wish = w.desk.slices();
        wish.placeMm = {-4, -2, -12};
        w.desk.setSlices(wish);
    });
    pressed("to its beginning", kHomeKey);
    pressed("right", kRightKey);
    pressed("right", kRightKey);
    pressed("left", kLeftKey);
    pressed("steer right", kRightKey, true);
    pressed("steer left", kLeftKey, true);
    pressed("up", kUpKey);
    pressed("down", kDownKey);
    pressed("nothing", 'Z');
    w.step("look around", [&] { w.drag({300, 300}, {340, 260}); });
    w.step("far up", [&] { w.drag({300, 300}, {300, 590}), w.drag({300, 5}, {300, 590}); });
    w.step("not with Shift", [&] { w.keyed(&ImGuiIO::KeyShift, [&] { w.drag({300, 300}, {340, 260}); }); });
    pressed("ahead again", kHomeKey);
    w.step("a patch", [&] { w.endoscopy.lookAtPatch(w.desk, 3); });
    w.step("none", [&] { w.endoscopy.lookAtPatch(w.desk, 14); });
    w.step("to the end", [&] { w.endoscopy.flyTo(w.desk, 1e6); });
    w.step("to the beginning", [&] { w.endoscopy.flyTo(w.desk, -1e6); });
    w.step("a line that leaks", [&] {
        w.endoscopy.find(w.desk, {{1, 2, 3}}, false);
        foundLine(w.viewing, true);
    });
    w.step("a question", [&] { w.endoscopy.flyTo(w.desk, 20); });
    w.step("the answer", [&] { w.endoscopy.answer(w.desk, Endoscopy::Answer::fly); });
    w.step("stop", [&] { w.endoscopy.stop(w.desk); });
    compareWithRecord(w, "picture-lines");
}

/// Clicks on planes gather places; one on the picture meets a wall.
TEST(WindowLines, PlacesAreGatheredOnPlanes) {
    PanelWindow w;
    w.frame();
    EXPECT_FALSE(w.endoscopy.placed(w.desk, {1, 2, 3})) << "nobody asked";
    w.clickOn("Endoscopy");
    w.rest();
    w.clickOn("line: click its points");
    EXPECT_TRUE(w.desk.showSlices);
    EXPECT_FALSE(w.endoscopy.press(w.desk, kEnterKey, false)) << "no place yet";
    w.click(glm::dvec2(500, 100));
    EXPECT_EQ(w.desk.message()->text, "click in the lumen, on a plane");
    w.rest();
    const Camera before = w.desk.camera();
    w.drag({500, 100}, {560, 140});
    EXPECT_EQ(w.desk.camera(), before) << "nor does it turn the picture";
    const auto dots = [&] {
        return std::count_if(w.drawn.begin(), w.drawn.end(),
                             [](const Drawn& d) { return d.colour == 0xFF5AE6FF; });
    };
    EXPECT_EQ(dots(), 0);
    w.click(glm::dvec2(800, 50)); // of the planes right of the picture
    w.click(glm::dvec2(820, 60));
    EXPECT_EQ(dots(), 2);
    EXPECT_TRUE(w.endoscopy.press(w.desk, kEnterKey, false));
    EXPECT_EQ(w.viewing.lineWish.places.size(), 2u);
    EXPECT_FALSE(w.viewing.lineWish.tree);
    EXPECT_TRUE(w.endoscopy.isSearching());
    EXPECT_TRUE(w.endoscopy.advance(w.desk)) << "more comes";
    w.frame();
    EXPECT_EQ(dots(), 0);
    w.viewing.said.clear();
    w.endoscopy.stop(w.desk);
    EXPECT_EQ(w.viewing.said, (std::vector<std::string>{"line called off"}));
    EXPECT_FALSE(w.endoscopy.hasLine());
    EXPECT_EQ(w.endoscopy.lengthMm(), 0);
}

/// A flight goes as far as its time, is asked for picture by picture, and ends at its end.
TEST(WindowLines, AFlightKeepsItsSpeed) {
    using Clock = WindowClock;
    PictureWindow w;
    w.frame();
    w.endoscopy.find(w.desk, {{1, 2, 3}}, false);
    foundLine(w.viewing, false);
    w.frame();
    ASSERT_TRUE(w.endoscopy.hasLine());
    EXPECT_FALSE(w.endoscopy.isSearching());
    EXPECT_NEAR(w.endoscopy.lengthMm(), 80, 0.5);
    w.endoscopy.flyTo(w.desk, 10);
    const auto height = [&] { return w.desk.camera().position.z; };
    EXPECT_NEAR(height(), -40, 0.3);
    EXPECT_FALSE(w.endoscopy.isPlaying());
    w.endoscopy.press(w.desk, kSpaceKey, false);
    EXPECT_TRUE(w.endoscopy.isPlaying());
    w.frame();
    const auto start = Clock::now();
    const double from = height();
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
    const std::uint64_t before = w.viewing.shows;
    w.frame();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    EXPECT_EQ(w.viewing.shows, before + 1);
    EXPECT_TRUE(w.viewing.moving);
    EXPECT_GT(height() - from, 20 * 0.05) << "20 mm a second";
    EXPECT_LT(height() - from, 20 * seconds + 0.5);
    EXPECT_LE(w.viewing.said.size(), 40u);
    // Without the picture that was asked for nothing else is.
    w.viewing.drawn.reset();
    w.frame();
    const std::uint64_t asked = w.viewing.shows;
    const double there = height();
    w.frame();
    EXPECT_EQ(w.viewing.shows, asked);
    EXPECT_EQ(height(), there);
    w.viewing.drawn = std::make_shared<ShownPicture>();
    w.endoscopy.press(w.desk, kSpaceKey, false);
    EXPECT_FALSE(w.endoscopy.isPlaying());
    EXPECT_FALSE(w.viewing.moving);
    w.endoscopy.flyTo(w.desk, 79.5);
    w.endoscopy.play(w.desk, true);
    const auto end = Clock::now() + std::chrono::seconds(20);
    while (w.endoscopy.isPlaying() && Clock::now() < end)
        w.frame();
    EXPECT_FALSE(w.endoscopy.isPlaying());
    EXPECT_NEAR(height(), 30, 0.3);
    EXPECT_FALSE(w.viewing.moving);
    w.endoscopy.play(w.desk, true);
    EXPECT_NEAR(height(), -50, 0.3) << "from its beginning again";
    w.endoscopy.stop(w.desk);
    EXPECT_FALSE(w.endoscopy.isPlaying());
}

/// A line of which the user is asked halts meanwhile, and goes on as it was about to.
TEST(WindowLines, AQuestionHaltsAFlight) {
    for (const auto answer : {Endoscopy::Answer::cancel, Endoscopy::Answer::fly, Endoscopy::Answer::stop}) {
        PictureWindow w;
        w.frame();
        w.endoscopy.find(w.desk, {{1, 2, 3}}, false);
        foundLine(w.viewing, true);
        w.frame();
        const Camera before = w.desk.camera();
        w.endoscopy.play(w.desk, true);
        EXPECT_TRUE(w.endoscopy.asks());
        EXPECT_FALSE(w.endoscopy.isPlaying());
        EXPECT_EQ(w.desk.camera(), before);
        w.endoscopy.answer(w.desk, answer);
        EXPECT_FALSE(w.endoscopy.asks());
        EXPECT_EQ(w.endoscopy.isPlaying(), answer != Endoscopy::Answer::cancel);
        EXPECT_NEAR(w.endoscopy.lengthMm(), answer == Endoscopy::Answer::stop ? 30 : 80, 0.5);
        EXPECT_EQ(w.desk.camera() == before, answer == Endoscopy::Answer::cancel);
        w.endoscopy.stop(w.desk);
        w.endoscopy.flyTo(w.desk, 5);
        EXPECT_EQ(w.endoscopy.asks(), answer == Endoscopy::Answer::cancel) << "asked once";
        w.endoscopy.stop(w.desk);
        EXPECT_FALSE(w.endoscopy.asks());
    }
}

/// Within a flight a map shows the place; who leaves sees the lines from outside.
TEST(WindowLines, AFlightIsLeft) {
    PanelWindow w;
    w.frame();
    w.endoscopy.find(w.desk, {{1, 2, 3}}, false);
    foundLine(w.viewing, false);
    w.clickOn("Endoscopy");
    w.rest();
    EXPECT_FALSE(w.endoscopy.advance(w.desk));
    w.endoscopy.flyTo(w.desk, 10);
    w.rest();
    EXPECT_TRUE(w.shows("10 of 80 mm"));
    w.clickOn("leave");
    w.rest();
    EXPECT_FALSE(w.shows("of 80 mm"));
    EXPECT_FALSE(w.endoscopy.isPlaying());
}

TEST(WindowLines, AreSavedAndLoaded) {
    const ScratchFolder folder;
    std::optional<PictureWindow> first(std::in_place);
    PictureWindow& w = *first;
    w.frame();
    EXPECT_THROW(w.endoscopy.save(w.desk, folder / "p.json"), InputError);
    EXPECT_THROW(w.endoscopy.measureCoverage(w.desk, false), InputError);
    w.endoscopy.find(w.desk, {{1, 2, 3}}, false);
    foundLine(w.viewing, false);
    w.frame();
    for (const double mm : {40.0, 10.0, 70.0, 10.0}) {
        w.endoscopy.flyTo(w.desk, mm);
        w.endoscopy.record(w.desk);
    }
    w.endoscopy.save(w.desk, folder / "p.json");
    Path path = loadPath(folder / "p.json");
    EXPECT_EQ(path.lines, pretendedPath(false)->lines);
    ASSERT_EQ(path.keyframes.size(), 3u) << "one place, one keyframe";
    for (std::size_t n = 0; n < 3; ++n)
        EXPECT_NEAR(*path.keyframes[n].placeMm, (std::vector<double>{10, 40, 70})[n], 1e-9);
    const double length = w.endoscopy.lengthMm();
    first.reset(); // ImGui has one window at a time
    PictureWindow other;
    other.frame();
    other.endoscopy.load(other.desk, folder / "p.json");
    EXPECT_EQ(other.endoscopy.lengthMm(), length);
    other.endoscopy.save(other.desk, folder / "q.json");
    EXPECT_EQ(pathJson(loadPath(folder / "q.json")), pathJson(path));
    path.volume = PathVolume{"hash", {40, 50, 61}};
    std::ofstream(folder / "other.json") << pathJson(path);
    EXPECT_THROW(other.endoscopy.load(other.desk, folder / "other.json"), Error);
    path.volume->extentVoxels.z = 60;
    std::ofstream(folder / "same.json") << pathJson(path);
    EXPECT_NO_THROW(other.endoscopy.load(other.desk, folder / "same.json"));
}

} // namespace
} // namespace tessera::test

// tests/viewer/window/window_state_test.cpp: edits at the window's desk, without a window or a volume's
// picture: each of them, what is measured as well, is taken back and done again as one step. What is asked
// for and when, and what is told.
#include "tests/support/desk.h"
#include "viewer/session/view_geometry.h" // heldBy()
#include "viewer/window/tools.h"
#include "viewer/window/window_state.h"

#include <gtest/gtest.h>
#include <thread>

namespace tessera {
namespace {

using test::Desk;

TEST(WindowState, WhatIsMeasuredIsTakenBackAndDoneAgain) {
    Desk d;
    WindowState& desk = d.desk;
    ASSERT_TRUE(desk.volume());
    Tools tools;
    std::vector<std::string> states = {sceneJson(desk.scene())}; // after as many edits
    for (const auto& [tool, points] :
         {std::pair{Tools::Tool::distance, 2}, {Tools::Tool::angle, 3}, {Tools::Tool::circle, 3}}) {
        tools.take(tool);
        for (int n = 0; n < points; ++n)
            EXPECT_TRUE(tools.placed(desk, {n, n * n, states.size()}));
        EXPECT_EQ(desk.scene().measurements.size(), states.size());
        EXPECT_FALSE(tools.placed(desk, glm::dvec3(0))) << "it is whole";
        states.push_back(sceneJson(desk.scene()));
    }
    for (std::size_t left = states.size() - 1; left-- > 0;) {
        ASSERT_TRUE(desk.history().canUndo());
        desk.undo();
        EXPECT_EQ(sceneJson(desk.scene()), states[left]) << left;
    }
    EXPECT_FALSE(desk.history().canUndo());
    for (std::size_t done = 1; done < states.size(); ++done) {
        desk.redo();
        EXPECT_EQ(sceneJson(desk.scene()), states[done]) << done;
    }
    EXPECT_FALSE(desk.history().canRedo());
}

TEST(WindowState, ForgetsNoMoreThanTheOldestEdits) {
    Desk d;
    for (int n = 0; n < 250; ++n) {
        d.desk.beginEdit();
        Scene scene = d.desk.scene();
        scene.shading.ambient = n / 1000.0;
        d.desk.setScene(scene, false);
    }
    int taken = 0;
    for (; d.desk.history().canUndo(); ++taken)
        d.desk.undo();
    EXPECT_EQ(taken, 200);
    EXPECT_EQ(d.desk.scene().shading.ambient, 49 / 1000.0);
    for (; d.desk.history().canRedo(); --taken)
        d.desk.redo();
    EXPECT_EQ(taken, 0);
    EXPECT_EQ(d.desk.scene().shading.ambient, 249 / 1000.0);
    d.desk.undo();
    d.desk.beginEdit();
    EXPECT_FALSE(d.desk.history().canRedo()) << "another edit";
}

TEST(WindowState, LatenciesAreThoseOfTheLastPictures) {
    Latency latency;
    const auto now = WindowClock::now();
    EXPECT_EQ(latency.percentileMs(0.5), 0);
    EXPECT_EQ(latency.picturesPerSecond(now), 0);
    for (int n = 0; n < 300; ++n)
        latency.drew(n, now - std::chrono::milliseconds(10 * (299 - n)));
    EXPECT_EQ(latency.lastMs, 299);
    EXPECT_EQ(latency.recentMs.size(), 200u);
    EXPECT_EQ(latency.percentileMs(0), 100);
    EXPECT_EQ(latency.percentileMs(1), 299);
    EXPECT_EQ(latency.percentileMs(0.5), 199);
    EXPECT_EQ(latency.picturesPerSecond(now), 100);
    Desk d;
    d.desk.setCamera(d.desk.camera(), true);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    d.draw();
    EXPECT_EQ(d.desk.latency().recentMs.size(), 1u);
    EXPECT_GE(d.desk.latency().lastMs, 19);
    EXPECT_LT(d.desk.latency().lastMs, 10000);
    for (int n = 0; n < 300; ++n) { // pictures without a question
        d.viewing.drawn = std::make_shared<ShownPicture>(*d.viewing.drawn);
        d.desk.update();
    }
    EXPECT_EQ(d.desk.latency().recentMs.size(), 1u);
    EXPECT_EQ(d.desk.latency().pictureTimes.size(), 200u);
}

/// A camera that somebody set stays when the pane gets another size, and comes back with the first size.
TEST(WindowState, ASetCameraStaysWhenThePaneChanges) {
    Desk d;
    Camera mine = d.desk.camera();
    mine.position = mine.focalPoint + glm::dvec3(0, 0, 300);
    mine.viewUp = {0, 1, 0};
    d.desk.setCamera(mine, false);
    const auto sized = [&](const glm::ivec2& size) {
        d.desk.setPictureSize(size);
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        d.desk.settle();
        EXPECT_EQ(d.desk.scene().imageSize, size);
        return d.desk.camera();
    };
    EXPECT_EQ(sized({300, 400}), heldBy(mine, {400, 300}, {300, 400})) << "as wide as it was";
    EXPECT_EQ(sized({400, 300}), mine);
}

/// What moves is asked for as such, and once more when it has come to rest.
TEST(WindowState, AsksOnceMoreAtRest) {
    Desk d;
    EXPECT_TRUE(d.desk.hasAsked());
    d.desk.setCamera(d.desk.camera(), true);
    EXPECT_TRUE(d.viewing.moving);
    EXPECT_FALSE(d.desk.hasAsked());
    EXPECT_TRUE(d.desk.settle());
    EXPECT_EQ(d.viewing.shows, 1u) << "too early";
    std::this_thread::sleep_for(std::chrono::milliseconds(190));
    d.desk.settle();
    EXPECT_EQ(d.viewing.shows, 2u);
    EXPECT_FALSE(d.viewing.moving);
    EXPECT_TRUE(d.desk.hasAsked());
    EXPECT_EQ(d.desk.asked(), 2u);
    d.desk.settle();
    EXPECT_EQ(d.viewing.shows, 2u);
    EXPECT_FALSE(d.desk.isAnswered());
    d.draw();
    EXPECT_TRUE(d.desk.isAnswered());
    EXPECT_FALSE(d.desk.isRefused());
    d.viewing.drawn->asked = 1;
    EXPECT_FALSE(d.desk.isAnswered()) << "an older picture";
    d.viewing.drawn->asked = 2;
    d.viewing.now.refused = 2;
    d.viewing.now.problem = "it does not fit";
    d.desk.update();
    EXPECT_TRUE(d.desk.isRefused());
    EXPECT_EQ(d.desk.lastProblem(), "it does not fit");
    ASSERT_TRUE(d.desk.message());
    EXPECT_TRUE(d.desk.message()->problem);
    EXPECT_EQ(d.viewing.now.problem, "") << "it was seen";
    d.viewing.notice = "a file is there";
    d.desk.update();
    EXPECT_EQ(d.desk.message()->text, "a file is there");
    EXPECT_FALSE(d.desk.message()->problem);
}

TEST(WindowState, MessagesStayAsLongAsTheyMatter) {
    Desk d;
    for (const bool problem : {false, true}) {
        d.desk.tell("words", problem);
        const auto left = d.desk.message()->until - WindowClock::now();
        EXPECT_LE(left, std::chrono::seconds(problem ? 12 : 4));
        EXPECT_GT(left, std::chrono::seconds(problem ? 11 : 3));
    }
    EXPECT_EQ(Desk().desk.message()->text, "the gantry was tilted");
}

} // namespace
} // namespace tessera

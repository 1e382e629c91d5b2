// tests/program/window_panes_test.cpp: the contents of a pane fit it, on displays and in panes of any size.
#include "tests/support/window_fixture.h"

namespace tessera::test {
namespace {

// Twice as many pixels to a unit: the picture has them all, the panel is as wide in units, and what is
// clicked is what lies there.
TEST_F(WindowTest, OnAFineDisplayUnitsHaveMorePixels) {
    if (std::system("command -v xrdb >/dev/null") != 0)
        GTEST_SKIP() << "xrdb is not installed";
    ASSERT_EQ(std::system("echo 'Xft.dpi: 192' | xrdb -merge"), 0);
    size_ = "600x450";
    start(TESSERA_TORSO);
    ASSERT_TRUE(rests());
    ASSERT_EQ(std::system("xdotool windowfocus --sync $(xdotool search --name Tessera | tail -1)"), 0);
    ASSERT_TRUE(isThePictureOfItsScene());
    const double wide = std::floor((600 - 330) * 0.72); // beside the panel, the planes' 28 %
    EXPECT_NEAR(picture_.size.x, 2 * wide, 1);
    EXPECT_EQ(picture_.size.y, 900);
    ASSERT_TRUE(after("key Tab sleep 0.3 key x"));
    ASSERT_TRUE(isThePictureOfItsScene());
    EXPECT_EQ(picture_.size, glm::ivec2(1200, 900));
    const std::vector<glm::dvec2> clicks = {{560, 380}, {640, 560}};
    ASSERT_TRUE(
        after("key m mousemove 560 380 sleep 0.3 click 1 sleep 1 mousemove 640 560 sleep 0.3 click 1"));
    const Scene now = scene();
    ASSERT_EQ(now.measurements.size(), 1u);
    ASSERT_EQ(now.measurements[0].points.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        const glm::dvec2 seen = inWindow(now, now.measurements[0].points[i]) - glm::dvec2(330, 0);
        EXPECT_NEAR(seen.x, clicks[i].x, 1.01) << i;
        EXPECT_NEAR(seen.y, clicks[i].y, 1.01) << i;
    }
}

// One rule: the visible region fits its pane, whatever the pane's shape, from every side and after every
// preset. A view that the user moved stays in the picture if the pane gets narrower.
TEST_F(WindowTest, WhatShowsFitsItsPane) {
    std::ofstream(folder_ / "s.txt") << "wait still\npicture first.png\n"
                                        "view left\nwait still\npicture left.png\n"
                                        "preset skin\nwait still\npicture skin.png\n"
                                        "planes off\npanels off\nwait still\npicture wide.png\n"
                                        "orbit 30 20\nzoom 3\nfit\nwait still\npicture fitted.png\n"
                                        "planes on\npanels on\nwait still\npicture narrow.png\n"
                                        "projection parallel\nwait still\npicture parallel.png\n"
                                        "mode isosurface\nwait still\npicture surface.png\n"
                                        "mode slice\nwait still\npicture slice.png\n"
                                        "view left\nwait still\npicture sagittal.png\n"
                                        "mode composite\nwait still\npicture back.png\nquit\n";
    start(TESSERA_TORSO, "s.txt");
    ASSERT_EQ(window_->exitCode(100s), 0) << readAll(folder_ / "window.txt");
    for (const char* const name : {"first", "left", "skin", "wide", "fitted", "narrow", "parallel", "surface",
                                   "slice", "sagittal", "back"}) {
        const Image picture = readImage(folder_ / (std::string(name) + ".png"));
        const glm::ivec2 size = picture.size;
        glm::ivec2 low = size, high(-1);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                if (const glm::vec4 p = picture.pixels[static_cast<std::size_t>(y * size.x + x)];
                    p.r + p.g + p.b > 0.02f)
                    low = glm::min(low, {x, y}), high = glm::max(high, {x, y});
        ASSERT_GT(high.x, 0) << name << " shows nothing";
        EXPECT_GT(low.x, 0) << name;
        EXPECT_GT(low.y, 0) << name;
        EXPECT_LT(high.x, size.x - 1) << name;
        EXPECT_LT(high.y, size.y - 1) << name;
        const glm::dvec2 part = glm::dvec2(high - low + 1) / glm::dvec2(size);
        const bool slice = std::string(name) == "slice" || std::string(name) == "sagittal";
        EXPECT_GT(std::max(part.x, part.y), slice ? 0.6 : 0.85) // slices fit with the air around the patient
            << name << " fills " << part.x << " x " << part.y;
    }
}

// More pixels than are shown are those of `tessera render` with that size.
TEST_F(WindowTest, APictureIsSavedLargerThanItIsShown) {
    std::ofstream(folder_ / "s.txt") << "wait still\npicture torso.png 2\nwait 500\nwait rest\n"
                                        "scene torso.json\nscale-bar on\npicture torso-bar.png 2\nwait 500\n"
                                        "wait rest\nquit\n";
    start(TESSERA_TORSO, "s.txt");
    ASSERT_EQ(window_->exitCode(100s), 0) << readAll(folder_ / "window.txt");
    const Image large = readImage(folder_ / "torso.png");
    const glm::ivec2 size = loadScene(folder_ / "torso.json").imageSize;
    ASSERT_EQ(large.size, 2 * size);
    const auto drawn = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words = {TESSERA_PROGRAM,
                                          "render",
                                          "torso.json",
                                          "-o",
                                          "drawn.png",
                                          "--ram",
                                          "256MiB",
                                          "--gpu-memory",
                                          "128MiB",
                                          "--size",
                                          std::to_string(large.size.x) + "x" + std::to_string(large.size.y)};
        words.insert(words.end(), more.begin(), more.end());
        Process render(words, folder_.path(), folder_ / "render.txt");
        EXPECT_EQ(render.exitCode(60s), 0) << readAll(folder_ / "render.txt");
        return readImage(folder_ / "drawn.png").pixels;
    };
    EXPECT_TRUE(large.pixels == drawn({}));
    const Image barred = readImage(folder_ / "torso-bar.png");
    EXPECT_TRUE(barred.pixels == drawn({"--scale-bar"}));
    int changed = 0;
    for (int y = 0; y < barred.size.y; ++y)
        for (int x = 0; x < barred.size.x; ++x)
            if (barred.at(x, y) != large.at(x, y)) {
                ++changed;
                EXPECT_TRUE(x > barred.size.x / 3 && y > barred.size.y * 3 / 4) << x << " " << y;
            }
    EXPECT_GT(changed, 400);
}

// The size that is named is the size that one gets, whatever is remembered.
TEST_F(WindowTest, ASizeThatIsNamedIsTaken) {
    fs::create_directories(folder_ / "config/tessera");
    std::ofstream(folder_ / "config/tessera/window.json") << R"({"windowSize": [700, 500]})";
    const auto sizeNow = [&] {
        return printed("xdotool getwindowgeometry --shell $(xdotool search --name Tessera | tail -1) | "
                       "sed -n 's/^\\(WIDTH\\|HEIGHT\\)=//p' | tr '\\n' ' '");
    };
    start(TESSERA_TORSO); // --size 900x600
    ASSERT_TRUE(rests());
    EXPECT_EQ(sizeNow(), "900 600 ");
    EXPECT_EQ(std::system("xdotool key ctrl+q"), 0);
    ASSERT_EQ(window_->exitCode(10s), 0);
    size_.clear();
    start(TESSERA_TORSO);
    ASSERT_TRUE(rests());
    EXPECT_EQ(sizeNow(), "900 600 ") << "remembered";
}

} // namespace
} // namespace tessera::test

// tests/program/window_beside_test.cpp: two scans side by side in the real window: a scan beside itself is
// the same everywhere, in what is shown, printed and saved.
#include "tests/support/window_fixture.h"

namespace tessera::test {
namespace {

/// True if the picture's right half is its left one.
bool isTwice(const Image& picture, int gap) {
    const int width = (picture.size.x - gap) / 2;
    for (int y = 0; y < picture.size.y; ++y)
        for (int x = 0; x < width; ++x)
            if (picture.at(x, y) != picture.at(x + width + gap, y))
                return false;
    return picture.size.x == 2 * width + gap;
}

TEST_F(WindowTest, AScanBesideItselfIsTheSame) {
    std::ofstream(folder_ / "s.txt") << "wait still\nprint beside\nplace 3 4 5\nwait 1500\nprint planes\n"
                                        "scale-bar on\npicture shown.png\npick 145 300\n"
                                        "pick 145 300 beside\nmode slice\nwait still\npicture slice.png\n"
                                        "wait 200\npick 145 300\npick 145 300 beside\nmode composite\n"
                                        "wait still\nscale-bar off\n"
                                        "picture large.png 2\nwait 500\nwait rest\nscene torso.json\n"
                                        "link look off\nlink places middles\nwait rest\nprint beside\nquit\n";
    size_ = "1300x600";
    start(TESSERA_TORSO, "s.txt", {"--beside", TESSERA_TORSO});
    ASSERT_EQ(window_->exitCode(100s), 0) << readAll(folder_ / "window.txt");
    std::vector<std::string> said;
    std::istringstream lines(readAll(folder_ / "window.txt"));
    for (std::string line; std::getline(lines, line);)
        said.push_back(line);
    ASSERT_EQ(said.size(), 8u) << readAll(folder_ / "window.txt");
    EXPECT_THAT(said[0], ::testing::AnyOf(HasSubstr("patient coordinates"), HasSubstr("same frame")));
    EXPECT_THAT(said[1], HasSubstr("planes: "));
    EXPECT_THAT(said[1], HasSubstr(" at 3.000 4.000 5.000 mm"));
    EXPECT_EQ(said[2].substr(8), said[1].substr(8));
    for (const std::size_t n : {3u, 5u}) { // in the volume, and on the slice
        EXPECT_THAT(said[n], ::testing::MatchesRegex("picked .* at .*"));
        EXPECT_EQ(said[n + 1], said[n]);
    }
    EXPECT_THAT(said[7], HasSubstr("middle on middle"));

    const glm::ivec2 size = loadScene(folder_ / "torso.json").imageSize;
    const Image shown = readImage(folder_ / "shown.png"), slice = readImage(folder_ / "slice.png"),
                large = readImage(folder_ / "large.png");
    EXPECT_EQ(shown.size, glm::ivec2(2 * size.x + 8, size.y));
    EXPECT_EQ(large.size, glm::ivec2(4 * size.x + 8, 2 * size.y));
    for (const Image* const picture : {&shown, &slice, &large})
        EXPECT_TRUE(isTwice(*picture, 8));
    Process redraw({TESSERA_PROGRAM, "redraw", "large.png", "--data", TESSERA_TORSO}, folder_.path(),
                   folder_ / "redraw.txt");
    EXPECT_EQ(redraw.exitCode(60s), 0);
    EXPECT_THAT(readAll(folder_ / "redraw.txt"), HasSubstr("pixels:   equal"));
}

} // namespace
} // namespace tessera::test

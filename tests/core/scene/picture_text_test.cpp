// tests/core/scene/picture_text_test.cpp: text, scale bars and legends dot by dot: what a reader sees.
#include "core/scene/picture_text.h"

#include "core/scene/colour_legend.h"
#include "core/scene/measurement.h"

#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace tessera {
namespace {

const glm::vec4 kPaper(0.5f, 0.5f, 0.5f, 0.5f), kWhite(1), kBlack(0, 0, 0, 1);

Image paper(const glm::ivec2& size) {
    Image image(size);
    image.pixels.assign(image.pixels.size(), kPaper);
    return image;
}
/// Rows of a picture: '#' white, 'o' black, '.' untouched, '?' anything else.
std::vector<std::string> seen(const Image& image) {
    std::vector<std::string> rows;
    for (int y = 0; y < image.size.y; ++y) {
        std::string& row = rows.emplace_back();
        for (int x = 0; x < image.size.x; ++x) {
            const glm::vec4& p = image.at(x, y);
            row += p == kWhite ? '#' : p == kBlack ? 'o' : p == kPaper ? '.' : '?';
        }
    }
    return rows;
}
std::string joined(const std::vector<std::string>& rows) {
    std::string all;
    for (const std::string& row : rows)
        all += row + "\n";
    return all;
}

TEST(PictureText, LettersAreOfFiveBySevenDots) {
    Image image = paper({19, 9});
    PicturePen(image, kWhite).write({1, 1}, "T-4", 1, 0);
    EXPECT_EQ(joined(seen(image)), "...................\n"
                                   ".#####..........#..\n"
                                   "...#...........##..\n"
                                   "...#..........#.#..\n"
                                   "...#...#####.#..#..\n"
                                   "...#.........#####.\n"
                                   "...#............#..\n"
                                   "...#............#..\n"
                                   "...................\n");
    // Twice as large, every dot a pixel larger on each side; what does not fit is left out.
    image = paper({8, 9});
    PicturePen(image, kWhite).write({-1, 2}, "/", 2, 1);
    EXPECT_EQ(joined(seen(image)), "........\n"
                                   "........\n"
                                   "........\n"
                                   "......##\n"
                                   "......##\n"
                                   "....####\n"
                                   "....####\n"
                                   "..######\n"
                                   "..######\n");
    image = paper({13, 7}); // a letter that there is not leaves a gap
    PicturePen(image, kWhite).write({0, 0}, "\x7f|", 1, 0);
    for (const std::string& row : seen(image))
        EXPECT_EQ(row, "........#....");
}

TEST(PictureText, DotsGrowWithThePicture) {
    for (const auto& [height, unit] :
         {std::pair{1, 1}, {300, 1}, {449, 1}, {450, 2}, {600, 2}, {749, 2}, {750, 3}, {3000, 10}})
        EXPECT_EQ(textUnit({7, height}), unit) << height;
}

TEST(PictureText, RectanglesEndBeforeTheirEnd) {
    Image image = paper({5, 4});
    PicturePen(image, kBlack).fill({1, 1}, {3, 3});
    PicturePen(image, kWhite).fill({-9, 3}, {2, 99});
    EXPECT_EQ(joined(seen(image)), ".....\n"
                                   ".oo..\n"
                                   ".oo..\n"
                                   "##...\n");
    const Image before = image;
    PicturePen(image, kWhite).fill({2, 2}, {2, 4});
    PicturePen(image, kWhite).fill({7, 0}, {9, 4});
    EXPECT_EQ(image.pixels, before.pixels) << "empty, and outside";
}

TEST(PictureText, AScaleBarIsDrawnDotByDot) {
    Image image = paper({46, 26});
    drawScaleBar(image, {5, 16.4, true});
    EXPECT_EQ(joined(seen(image)), "..............................................\n"
                                   "..............................................\n"
                                   "..............................................\n"
                                   "..............................................\n"
                                   "..............................................\n"
                                   "..............................................\n"
                                   "................ooooooo.......................\n"
                                   "................o#####o.......................\n"
                                   "................o#ooooo.....oooooooooooo......\n"
                                   "................o####oo.....o##o#oo##o#oo.....\n"
                                   "................ooooo#o.....o#o#o#o#o#o#o.....\n"
                                   "................ooo.o#o.....o#o#o#o#o#o#o.....\n"
                                   "................o#ooo#o.....o#o#o#o#o#o#o.....\n"
                                   "................oo###oo.....o#o#o#o#o#o#o.....\n"
                                   ".................ooooo......ooooooooooooo.....\n"
                                   ".......................ooo............ooo.....\n"
                                   ".......................o#o............o#o.....\n"
                                   ".......................o#oooooooooooooo#o.....\n"
                                   ".......................o################o.....\n"
                                   ".......................o#oooooooooooooo#o.....\n"
                                   ".......................ooo............ooo.....\n"
                                   "..............................................\n"
                                   "..............................................\n"
                                   "..............................................\n"
                                   "..............................................\n"
                                   "..............................................\n");
}

TEST(PictureText, ALegendIsDrawnDotByDot) {
    Image image = paper({52, 40});
    LegendBar bar;
    bar.name = "pet";
    bar.low = 0, bar.high = 8;
    bar.colours = {glm::dvec3(0), glm::dvec3(1)};
    drawColourLegend(image, std::vector<LegendBar>{bar});
    EXPECT_EQ(joined(seen(image)), "....................................................\n"
                                   "....................................................\n"
                                   "....................................................\n"
                                   "....................................................\n"
                                   "....................................................\n"
                                   "....................................................\n"
                                   "....................................................\n"
                                   "..................ooo...............................\n"
                                   "..................o#o...............................\n"
                                   ".....oooooo.ooooooo#oo..............................\n"
                                   ".....o####ooo###oo###o..............................\n"
                                   ".....o#ooo#o#ooo#oo#oo..............................\n"
                                   ".....o####oo#####oo#oooo............................\n"
                                   ".....o#ooooo#oooooo#oo#o............................\n"
                                   ".....o#o...oo###o.oo##oo............................\n"
                                   ".....ooo....ooooo..oooo.............................\n"
                                   "....................................................\n"
                                   ".....oooooooooooooooooooooooooooooooooooooooooo.....\n"
                                   ".....ooooooooooooooooooooo####################o.....\n"
                                   ".....ooooooooooooooooooooo####################o.....\n"
                                   ".....ooooooooooooooooooooo####################o.....\n"
                                   ".....ooooooooooooooooooooo####################o.....\n"
                                   ".....ooooooooooooooooooooo####################o.....\n"
                                   ".....ooooooooooooooooooooo####################o.....\n"
                                   ".....oooooooooooooooooooooooooooooooooooooooooo.....\n"
                                   "....................................................\n"
                                   "......ooooo..............ooo.............ooooo......\n"
                                   ".....oo###oo............oo#o............oo###oo.....\n"
                                   ".....o#ooo#o...........oo##o............o#ooo#o.....\n"
                                   ".....o#oo##o..........oo#o#o............o#ooo#o.....\n"
                                   ".....o#o#o#o..........o#oo#oo...........oo###oo.....\n"
                                   ".....o##oo#o..........o#####o...........o#ooo#o.....\n"
                                   ".....o#ooo#o..........oooo#oo...........o#ooo#o.....\n"
                                   ".....oo###oo.............o#o............oo###oo.....\n"
                                   "......ooooo..............ooo.............ooooo......\n"
                                   "....................................................\n"
                                   "....................................................\n"
                                   "....................................................\n"
                                   "....................................................\n"
                                   "....................................................\n");
}

} // namespace
} // namespace tessera

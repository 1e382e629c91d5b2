// Pictures before a background, and their grids of fewer pixels.
#include "core/image/image.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

// Pictures are premultiplied: what light they have stays, and the background comes through the rest.
TEST(OverBackground, ComesThroughWhatIsLeft) {
    Image image(glm::ivec2(3, 1));
    image.at(0, 0) = glm::vec4(0);
    image.at(1, 0) = {0.25f, 0, 0.5f, 0.5f};
    image.at(2, 0) = {0.25f, 0, 0.5f, 1};
    const Image out = overBackground(image, {1, 0.5f, 0});
    EXPECT_EQ(out.at(0, 0), glm::vec4(1, 0.5f, 0, 1));
    EXPECT_EQ(out.at(1, 0), glm::vec4(0.75f, 0.25f, 0.5f, 1));
    EXPECT_EQ(out.at(2, 0), glm::vec4(0.25f, 0, 0.5f, 1));
}

TEST(Thinned, TakesTheMiddleOfEveryStride) {
    Image image(glm::ivec2(7, 6));
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 7; ++x)
            image.at(x, y).r = static_cast<float>(10 * y + x);
    const Image out = thinned(image, 3);
    EXPECT_EQ(out.size, glm::ivec2(2, 2));
    EXPECT_EQ(out.at(0, 0).r, 11);
    EXPECT_EQ(out.at(1, 1).r, 44);
    EXPECT_EQ(thinned(image, 1).pixels, image.pixels);
}

// One pixel is left of a side that is shorter than a stride: its last where the middle is past it.
TEST(Thinned, LeavesOnePixelOfAShortSide) {
    Image image(glm::ivec2(8, 2));
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 8; ++x)
            image.at(x, y).r = static_cast<float>(10 * y + x);
    const Image out = thinned(image, 4);
    EXPECT_EQ(out.size, glm::ivec2(2, 1));
    EXPECT_EQ(out.at(0, 0).r, 12);
    EXPECT_EQ(out.at(1, 0).r, 16);
    EXPECT_EQ(thinnedSize(image.size, 4), out.size);
    EXPECT_EQ(thinnedPixel({1, 0}, image.size, 4), glm::ivec2(6, 1));
}

} // namespace
} // namespace tessera

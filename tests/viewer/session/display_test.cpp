// tests/viewer/session/display_test.cpp: the pixels of a screen are those of the file; smaller pictures are
// enlarged without rims; pictures become smaller until they come in time.
#include "core/image/colour.h"
#include "viewer/session/frame_pace.h"
#include "viewer/session/shown_picture.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace tessera {
namespace {

std::uint32_t part(std::uint32_t pixel, int channel) {
    return pixel >> (8 * channel) & 255;
}

TEST(DisplayPixels, AreTheFilesBytes) {
    // Every code's threshold and its neighbours, and what no picture should have.
    std::vector<float> values = {
        -1, 0, 1, 2, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()};
    for (int code = 1; code < 256; ++code) {
        auto v = static_cast<float>(linearFromSrgb((code - 0.5) / 255));
        v = std::nextafter(std::nextafter(std::nextafter(v, 0.0f), 0.0f), 0.0f);
        for (int n = 0; n < 7; ++n, v = std::nextafter(v, 2.0f))
            values.push_back(v);
    }
    Image image({static_cast<int>(values.size()), 1});
    for (std::size_t i = 0; i < values.size(); ++i)
        image.pixels[i] = {values[i], values[i], values[i], 1};
    const auto shown = displayPixels(image, glm::vec3(0), image.size, 1);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double v = std::isnan(values[i]) ? 0.0 : static_cast<double>(values[i]);
        const auto expected = static_cast<std::uint32_t>(std::lround(255 * srgbFromLinear(v)));
        for (int c = 0; c < 3; ++c)
            ASSERT_EQ(part(shown[i], c), expected) << values[i];
        ASSERT_EQ(part(shown[i], 3), 255u);
    }
}

TEST(DisplayPixels, LieOnTheBackground) {
    Image image({1, 1});
    image.pixels[0] = {0.1f, 0.2f, 0.3f, 0.5f};
    const auto shown = displayPixels(image, glm::vec3(0.4f, 0.0f, 0.2f), {1, 1}, 1);
    EXPECT_EQ(part(shown[0], 0), static_cast<std::uint32_t>(std::lround(255 * srgbFromLinear(0.3))));
    EXPECT_EQ(part(shown[0], 1), static_cast<std::uint32_t>(std::lround(255 * srgbFromLinear(0.2))));
    EXPECT_EQ(part(shown[0], 2), static_cast<std::uint32_t>(std::lround(255 * srgbFromLinear(0.4))));
}

TEST(DisplayPixels, AnEnlargedEdgeIsSharpAndHasNoRim) {
    Image image({16, 12});
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 16; ++x)
            image.at(x, y) = glm::vec4(glm::vec3(x < 8 ? 0.1f : 0.7f), 1);
    const glm::ivec2 size(64, 48);
    const auto shown = displayPixels(image, glm::vec3(0), size, 2);
    const auto dark = static_cast<std::uint32_t>(std::lround(255 * srgbFromLinear(0.1f))),
               light = static_cast<std::uint32_t>(std::lround(255 * srgbFromLinear(0.7f)));
    for (int y = 0; y < size.y; ++y) {
        int between = 0;
        for (int x = 0; x < size.x; ++x) {
            const std::uint32_t v = part(shown[static_cast<std::size_t>(y * size.x + x)], 0);
            ASSERT_GE(v, dark) << "a rim";
            ASSERT_LE(v, light) << "a rim";
            between += v != dark && v != light;
        }
        EXPECT_LE(between, 4) << "wider than a pixel of the small picture";
        EXPECT_EQ(part(shown[static_cast<std::size_t>(y * size.x + 29)], 0), dark) << "it lies where it was";
        EXPECT_EQ(part(shown[static_cast<std::size_t>(y * size.x + 34)], 0), light);
    }
    EXPECT_EQ(displayPixels(image, glm::vec3(0), size, 1), shown) << "threads";
}

TEST(DisplayPixels, ARampStaysARamp) {
    Image image({20, 9});
    for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 20; ++x)
            image.at(x, y) =
                glm::vec4(glm::vec3(static_cast<float>(x) / 19, static_cast<float>(y) / 8, 0), 1);
    const glm::ivec2 size(77, 31);
    const auto shown = displayPixels(image, glm::vec3(0), size, 1);
    for (int y = 6; y < 25; ++y)
        for (int x = 8; x < 69; ++x) {
            const std::uint32_t pixel = shown[static_cast<std::size_t>(y * size.x + x)];
            const double r = ((x + 0.5) * 20 / 77 - 0.5) / 19, g = ((y + 0.5) * 9 / 31 - 0.5) / 8;
            ASSERT_NEAR(part(pixel, 0), 255 * srgbFromLinear(r), 0.6);
            ASSERT_NEAR(part(pixel, 1), 255 * srgbFromLinear(g), 0.6);
        }
}

TEST(FramePace, ComesToAPictureThatIsInTime) {
    const glm::ivec2 whole(1280, 720);
    for (const double msPerPixel : {1e-6, 5e-5, 2e-4, 1e-3}) {
        FramePace pace(50);
        glm::ivec2 size(0), before(0);
        int changes = 0;
        for (int n = 0; n < 40; ++n) {
            size = pace.sizeFor(whole);
            changes += n > 20 && size != before;
            before = size;
            pace.drew(size, msPerPixel * size.x * size.y * (1 + 0.1 * (n % 3 - 1)));
        }
        EXPECT_EQ(changes, 0) << "a noise of a tenth changes no size";
        const double ms = msPerPixel * size.x * size.y;
        EXPECT_LE(ms, 55);
        if (size != whole) {
            EXPECT_GE(ms, 22) << "smaller than it must be";
        }
        EXPECT_NEAR(static_cast<double>(size.x) / size.y, 16.0 / 9, 0.02);
    }
}

TEST(FramePace, KeepsToAnEighthAndAPixel) {
    FramePace pace(5);
    pace.drew({100, 100}, 1e6);
    EXPECT_EQ(pace.sizeFor({1280, 720}), glm::ivec2(160, 90));
    EXPECT_EQ(pace.sizeFor({3, 1}), glm::ivec2(1, 1));
    pace.forget();
    EXPECT_GT(pace.sizeFor({1280, 720}).x, 160);
}

} // namespace
} // namespace tessera

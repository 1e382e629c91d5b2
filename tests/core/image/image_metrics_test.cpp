// ImageError against closed forms: a constant shift, equal pictures, a flat pair's similarity, what the mask
// leaves out and what it does not.
#include "core/image/image_metrics.h"

#include "core/image/colour.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace tessera {
namespace {

Image flat(const glm::ivec2& size, const glm::vec4& pixel) {
    Image image(size);
    for (glm::vec4& p : image.pixels)
        p = pixel;
    return image;
}

Image wavy(float shift) {
    Image image(glm::ivec2(40, 31));
    for (int y = 0; y < image.size.y; ++y)
        for (int x = 0; x < image.size.x; ++x) {
            const float v = 0.4f + 0.3f * std::sin(0.4f * static_cast<float>(x) + shift) *
                                       std::cos(0.3f * static_cast<float>(y));
            image.at(x, y) = glm::vec4(v, 0.5f * v, 0.8f * v, 1);
        }
    return image;
}

TEST(ImageErrors, OfAPictureAgainstItselfAreNothing) {
    const Image image = wavy(0);
    const ImageError e = measureError(image, image);
    EXPECT_EQ(e.maskedPixels, image.pixels.size());
    EXPECT_EQ(e.rmse, 0);
    EXPECT_EQ(e.maxAbs, 0);
    EXPECT_EQ(e.p999, 0);
    EXPECT_EQ(e.fracAbove1Of255, 0);
    EXPECT_EQ(e.psnr, std::numeric_limits<double>::infinity());
    EXPECT_NEAR(e.ssim, 1, 1e-12);
    EXPECT_EQ(e.luvP99, 0);
    EXPECT_EQ(e.nanCount, 0u);
}

TEST(ImageErrors, OfAConstantShiftAreTheShift) {
    const glm::vec4 truth(0.25f, 0.5f, 0.125f, 0.75f);
    const double shift = 1.0 / 128; // exact in float, above 1/255
    const Image image = flat({20, 12}, truth + glm::vec4(static_cast<float>(shift)));
    const ImageError e = measureError(image, flat({20, 12}, truth));
    EXPECT_DOUBLE_EQ(e.rmse, shift);
    EXPECT_DOUBLE_EQ(e.bias, shift);
    EXPECT_DOUBLE_EQ(e.maxAbs, shift);
    EXPECT_DOUBLE_EQ(e.p999, shift);
    EXPECT_EQ(e.fracAbove1Of255, 1);
    double squares = 0;
    glm::dvec3 moved(truth), still(truth);
    for (int c = 0; c < 3; ++c) {
        moved[c] += shift;
        squares += std::pow(srgbFromLinear(moved[c]) - srgbFromLinear(still[c]), 2);
    }
    EXPECT_NEAR(e.psnr, -10 * std::log10(squares / 3), 1e-9);
    EXPECT_NEAR(e.luvMean, e.luvP99, 1e-9);
    EXPECT_GT(e.luvMean, 0);
    const ImageError down = measureError(flat({20, 12}, truth), image);
    EXPECT_DOUBLE_EQ(down.bias, -shift);
}

// Flat pictures have no variance: SSIM is (2ab + C1) / (a^2 + b^2 + C1), C1 = 1e-4.
TEST(ImageErrors, SimilarityOfAFlatPairIsItsClosedForm) {
    const Image a = flat({24, 24}, {0.2f, 0.2f, 0.2f, 1}), b = flat({24, 24}, {0.6f, 0.6f, 0.6f, 1});
    const double la = srgbFromLinear(double{0.2f}), lb = srgbFromLinear(double{0.6f});
    EXPECT_NEAR(measureError(a, b).ssim, (2 * la * lb + 1e-4) / (la * la + lb * lb + 1e-4), 1e-9);
}

TEST(ImageErrors, SimilarityFallsWithDisplacement) {
    const Image truth = wavy(0);
    double before = 1;
    for (const float shift : {0.05f, 0.2f, 0.8f, 3.0f}) {
        const double ssim = measureError(wavy(shift), truth).ssim;
        EXPECT_LT(ssim, before) << shift;
        before = ssim;
    }
    EXPECT_LT(before, 0); // almost the opposite picture
}

TEST(ImageErrors, AreOverWhatTheTruthShows) {
    Image truth(glm::ivec2(10, 10)), image(glm::ivec2(10, 10));
    for (int y = 0; y < 10; ++y) { // a column in ten shows something, fainter than 8 bits can
        truth.at(3, y) = glm::vec4(0.001f);
        image.at(3, y) = glm::vec4(0.002f);
    }
    const ImageError e = measureError(image, truth);
    EXPECT_EQ(e.maskedPixels, 10u);
    EXPECT_NEAR(e.rmse, 0.001, 1e-9);
    EXPECT_EQ(e.fracAbove1Of255, 0);
    image.at(9, 9) = glm::vec4(0.5f); // lit, where the truth is black
    const ImageError lit = measureError(image, truth);
    EXPECT_NEAR(lit.rmse, 0.001, 1e-9);
    EXPECT_EQ(lit.maxAbs, 0.5);
}

// An error that 8 bits do not show is none of those above 1/255, though it is above 1/256.
TEST(ImageErrors, OfAStepAreCountedFromTheStepOn) {
    const Image truth = flat({4, 4}, glm::vec4(0.25f));
    EXPECT_EQ(measureError(flat({4, 4}, glm::vec4(0.25f + 0.00391f)), truth).fracAbove1Of255, 0);
    EXPECT_EQ(measureError(flat({4, 4}, glm::vec4(0.25f + 0.00393f)), truth).fracAbove1Of255, 1);
}

// One bad pixel in a hundred is beyond the 99th percentile, two are not.
TEST(ImageErrors, PercentilesLeaveOutWhatIsBeyondThem) {
    const Image truth = flat({10, 10}, {0.25f, 0.25f, 0.25f, 1});
    Image image = truth;
    image.at(4, 7) = {0.75f, 0.75f, 0.75f, 1};
    EXPECT_EQ(measureError(image, truth).luvP99, 0);
    EXPECT_GT(measureError(image, truth).luvMean, 0);
    image.at(5, 7) = {0.75f, 0.75f, 0.75f, 1};
    EXPECT_GT(measureError(image, truth).luvP99, 10);
}

// Similarity has no favourite axis: turned over its diagonal, a pair is as alike as before.
TEST(ImageErrors, SimilarityIsTheSameAlongBothAxes) {
    const auto turned = [](const Image& image) {
        Image out(glm::ivec2(image.size.y, image.size.x));
        for (int y = 0; y < image.size.y; ++y)
            for (int x = 0; x < image.size.x; ++x)
                out.at(y, x) = image.at(x, y);
        return out;
    };
    const Image a = wavy(0), b = wavy(0.4f);
    const double ssim = measureError(a, b).ssim;
    EXPECT_LT(ssim, 0.99);
    EXPECT_NEAR(measureError(turned(a), turned(b)).ssim, ssim, 1e-12);
}

TEST(ImageErrors, CountWhatIsNotFinite) {
    Image image = wavy(0);
    const Image truth = image;
    image.at(2, 2).g = std::numeric_limits<float>::quiet_NaN();
    image.at(7, 9) = glm::vec4(std::numeric_limits<float>::infinity());
    const ImageError e = measureError(image, truth);
    EXPECT_EQ(e.nanCount, 5u);
    EXPECT_EQ(e.maxAbs, 1);
    EXPECT_TRUE(std::isfinite(e.rmse) && std::isfinite(e.psnr) && std::isfinite(e.ssim) &&
                std::isfinite(e.luvP99));
    EXPECT_GT(e.rmse, 0);
}

TEST(ImageErrors, OfATruthThatShowsNothingAreNone) {
    const Image black(glm::ivec2(3, 3));
    const ImageError e = measureError(black, black);
    EXPECT_EQ(e.maskedPixels, 0u);
    EXPECT_EQ(e.rmse, 0);
}

// A picture measured against a truth that shows nothing: no error, no pixel, and as alike as can be.
TEST(ImageErrors, AgainstNothing) {
    const Image empty(glm::ivec2(7, 5));
    const ImageError error = measureError(empty, empty);
    EXPECT_EQ(error.maskedPixels + error.nanCount, 0u);
    EXPECT_EQ(error.rmse + error.bias + error.maxAbs + error.p999 + error.fracAbove1Of255 + error.luvMean +
                  error.luvP99,
              0);
    EXPECT_EQ(error.ssim, 1);
}

} // namespace
} // namespace tessera

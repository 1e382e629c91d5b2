// The choice of pixels that are drawn again: every pixel with the same chance, no pixel twice, in no round.
// Also their number.
#include "render/verify/measured_errors.h"
#include "render/verify/pixel_sample.h"
#include "render/verify/verify_plan.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <utility>

namespace tessera {
namespace {

using Place = std::pair<int, int>;

Place placeOf(const SampledPixel& p) {
    return {p.at.x, p.at.y};
}

// Odd sizes, tiles that do not divide them, a frame that leaves tiles empty or nearly so: each pixel of it is
// chosen as often as another, and none outside. 4.5 standard deviations: by chance one pixel in 150,000.
TEST(PixelChoice, EveryPixelOfTheFrameHasTheSameChance) {
    const glm::ivec2 size(37, 29);
    std::vector<std::uint8_t> frame;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            frame.push_back((x - 30) * (x - 30) + (y - 3) * (y - 3) < 260 || (x * y) % 7 == 3);
    for (const int perCluster : {1, 3})
        for (const int round : {0, 1}) {
            std::vector<int> chosen(frame.size(), 0);
            constexpr int kSeeds = 12000;
            double expected = 0;
            for (int seed = 0; seed < kSeeds; ++seed) {
                const PixelSample sample =
                    choosePixels(size, {24, perCluster, 5, static_cast<std::uint64_t>(seed)}, round, frame);
                ASSERT_FALSE(sample.all);
                ASSERT_EQ(sample.pixels.size(), 24u);
                // In round 1 a pixel was taken before, or has this chance.
                expected += sample.chance * (round == 0 ? 1
                                                        : static_cast<double>(sample.population) /
                                                              (static_cast<double>(sample.population) + 24));
                for (const SampledPixel& p : sample.pixels)
                    ++chosen[static_cast<std::size_t>(p.at.y * size.x + p.at.x)];
            }
            for (std::size_t i = 0; i < frame.size(); ++i) {
                if (!frame[i])
                    EXPECT_EQ(chosen[i], 0);
                else
                    EXPECT_NEAR(chosen[i], expected, 4.5 * std::sqrt(expected))
                        << "pixel " << i << ", round " << round;
            }
        }
}

TEST(PixelChoice, NoPixelIsTakenTwice) {
    const glm::ivec2 size(61, 40);
    for (const int perCluster : {1, 4}) {
        std::set<Place> taken;
        std::size_t left = 61 * 40; // five rounds, the last of all that is left
        for (int round = 0;; ++round) {
            const SampleDesign design{480, perCluster, 8, 7};
            const PixelSample sample = choosePixels(size, design, round);
            EXPECT_EQ(sample.population, left);
            EXPECT_NEAR(sample.chance, static_cast<double>(sample.pixels.size()) / static_cast<double>(left),
                        1e-12);
            for (const SampledPixel& p : sample.pixels)
                EXPECT_TRUE(taken.insert(placeOf(p)).second) << "round " << round;
            left -= sample.pixels.size();
            if (sample.all)
                break;
            EXPECT_EQ(sample.clusters * perCluster, 480);
        }
        EXPECT_EQ(left, 0u) << "rounds end with the last pixel";
        EXPECT_TRUE(choosePixels(size, {480, perCluster, 8, 7}, 100).pixels.empty());
    }
}

TEST(PixelChoice, DependsOnItsSeedAndRoundAlone) {
    const SampleDesign design{300, 1, 4, 42};
    const auto places = [&](const SampleDesign& d, int round) {
        std::vector<Place> out;
        for (const SampledPixel& p : choosePixels({128, 96}, d, round).pixels)
            out.push_back(placeOf(p));
        return out;
    };
    EXPECT_EQ(places(design, 1), places(design, 1));
    SampleDesign other = design;
    other.seed = 43;
    EXPECT_NE(places(design, 0), places(other, 0));
}

// Strata: a picture's quarters get their share, but for strata that lie across their borders. Clusters lie in
// a tile.
TEST(PixelChoice, IsSpreadOverThePictureAndClustersAreSmall) {
    const PixelSample sample = choosePixels({256, 256}, {1024, 4, 16, 3});
    int quarter[4] = {};
    for (const SampledPixel& p : sample.pixels)
        ++quarter[(p.at.x >= 128) + 2 * (p.at.y >= 128)];
    for (const int count : quarter)
        EXPECT_NEAR(count, 256, 4);
    for (std::size_t i = 1; i < sample.pixels.size(); ++i) {
        const SampledPixel &a = sample.pixels[i - 1], &b = sample.pixels[i];
        EXPECT_TRUE(a.cluster != b.cluster || (a.at.x / 16 == b.at.x / 16 && a.at.y / 16 == b.at.y / 16));
    }
}

TEST(PixelChoice, TakesAllOfASmallPicture) {
    const PixelSample sample = choosePixels({20, 25}, {400, 1, 4, 0});
    EXPECT_TRUE(sample.all);
    EXPECT_EQ(sample.pixels.size(), 500u);
    EXPECT_EQ(sample.chance, 1);
    EXPECT_FALSE(choosePixels({20, 27}, {400, 1, 4, 0}).all);
}

TEST(VerifyPlans, KeepTheirCost) {
    for (const int side : {64, 160, 320, 511, 512, 640, 1024, 2048})
        for (const double share : {0.02, 0.1, 0.2, 0.44, 1.0})
            for (const int samples : {1, 4, 16}) {
                VerifyInput input;
                input.size = {side, side};
                input.shown = static_cast<std::size_t>(share * side * side);
                input.samplesPerPixel = samples;
                const VerifyPlan plan = verifyPlan(input);
                SCOPED_TRACE(testing::Message()
                             << side << " pixels, " << share << " shown, " << samples << " samples");
                EXPECT_EQ(plan.design.perCluster, 1);
                EXPECT_GE(plan.replicates * plan.samples, 8);
                EXPECT_LE(plan.cost, side >= 512 ? kMostQuickCost : 1e9);
                const double expected = std::min(plan.design.pixels * share, share * side * side);
                // Rays of the truth, by what one costs, of the rays that the picture took where something
                // shows.
                const double again = expected * plan.replicates * plan.samples * input.costOfTruthRay;
                const double taken = static_cast<double>(input.shown) * samples;
                EXPECT_NEAR(plan.cost * taken / again, 1, 0.02);
                EXPECT_TRUE(!plan.tellsP99 || expected >= 340 || expected == share * side * side);
            }
}

TEST(VerifyPlans, AreThoseOfThePage) { // docs/measurements/measured-errors.md
    const auto plan = [](int side, double share, Verify mode) {
        VerifyInput input;
        input.size = {side, side};
        input.shown = static_cast<std::size_t>(share * side * side);
        input.mode = mode;
        return verifyPlan(input);
    };
    EXPECT_EQ(plan(512, 1, Verify::none).design.pixels, 0);
    EXPECT_EQ(plan(512, 0, Verify::full).design.pixels, 0);
    EXPECT_EQ(plan(1024, 1, Verify::quick).design.pixels, 1000);
    EXPECT_EQ(plan(1024, 0.5, Verify::quick).design.pixels, 2000);
    EXPECT_EQ(plan(512, 1, Verify::quick).design.pixels, 1000);
    EXPECT_EQ(plan(512, 0.5, Verify::quick).design.pixels, 1024); // 512 that show something, at a quarter
    EXPECT_EQ(plan(160, 1, Verify::quick).design.pixels, 400);
    EXPECT_TRUE(plan(160, 1, Verify::quick).tellsP99);
    EXPECT_FALSE(plan(512, 0.05, Verify::quick).tellsP99);
    EXPECT_EQ(plan(512, 1, Verify::full).design.pixels, 2000);
    EXPECT_EQ(plan(512, 1, Verify::full).samples, 16);
}

// As many clusters as means need, however few pixels the rays allow; what is left is for pixels on their own.
TEST(VerifyPlans, OfClustersAreThoseOfThePage) {
    VerifyInput input;
    input.size = {512, 512};
    for (const double share : {1.0, 0.5, 0.2, 0.1}) {
        SCOPED_TRACE(share);
        input.shown = static_cast<std::size_t>(share * 512 * 512);
        input.brickPixels = 64;
        input.costTaken = 0;
        const VerifyPlan clusters = verifyPlan(input);
        EXPECT_EQ(clusters.design.perCluster, share >= 0.5 ? 8 : share == 0.2 ? 6 : 3);
        EXPECT_EQ(clusters.design.tile, 16);
        const double shown = clusters.design.pixels * share;
        EXPECT_GE(shown / clusters.design.perCluster, 64);
        EXPECT_LE(shown / clusters.design.perCluster, 70);
        EXPECT_LE(clusters.cost, kMostQuickCost);
        EXPECT_FALSE(clusters.tellsP99);
        input.brickPixels = 0;
        input.costTaken = clusters.cost;
        const VerifyPlan pixels = verifyPlan(input);
        EXPECT_LE(clusters.cost + pixels.cost, kMostQuickCost * 1.001);
        EXPECT_EQ(pixels.tellsP99, share == 1);
    }
    input.brickPixels = 5;
    EXPECT_EQ(verifyPlan(input).design.tile, 12) << "pixels to choose from";
    input.mode = Verify::full;
    EXPECT_EQ(verifyPlan(input).design.perCluster, 1);
}

// Pictures may be larger than memory: pixels are chosen without a list of them, evenly over the picture.
TEST(PixelChoice, IsMadeOfAPictureOfAnySize) {
    VerifyInput input;
    input.size = {32768, 30001};
    input.shown = static_cast<std::size_t>(input.size.x) * 30001;
    const VerifyPlan plan = verifyPlan(input);
    EXPECT_LE(static_cast<double>(input.shown) / plan.design.tile / plan.design.tile, 1 << 17);
    std::set<Place> taken;
    int right = 0, below = 0;
    for (const int round : {0, 1}) {
        const PixelSample sample = choosePixels(input.size, plan.design, round);
        EXPECT_EQ(sample.population, input.shown - taken.size());
        for (const SampledPixel& p : sample.pixels) {
            EXPECT_TRUE(taken.insert(placeOf(p)).second);
            right += p.at.x >= input.size.x / 2 ? 1 : 0;
            below += p.at.y >= input.size.y / 2 ? 1 : 0;
        }
    }
    EXPECT_NEAR(right, 0.5 * static_cast<double>(taken.size()), 100);
    EXPECT_NEAR(below, 0.5 * static_cast<double>(taken.size()), 100);
}

} // namespace
} // namespace tessera

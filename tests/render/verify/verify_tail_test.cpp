// tests/render/verify/verify_tail_test.cpp: the tail of errors, of values that are known: ranks, percentiles,
// the truth's noise, and what clusters that err alike are worth.
#include "render/verify/measured_errors.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

/// So many pixels whose errors are 1, 2, 3...; with twice the noise they are as many times larger.
std::vector<PixelError> ascending(int count, double twice = 1) {
    std::vector<PixelError> errors;
    for (int n = count; n > 0; --n)
        errors.push_back({0, true, 0, double(n), twice * n, {twice * n, twice * n}});
    errors.push_back({0, false, 0, 1e9, 1e9, {1e9, 1e9}}); // shows nothing, so counts for nothing
    return errors;
}

TEST(Tails, HaveTheirRanks) {
    const Tail tail(ascending(1000));
    ASSERT_EQ(tail.values().size(), 1000u);
    EXPECT_EQ(tail.values().front(), 1);
    EXPECT_EQ(tail.values().back(), 1000);
    EXPECT_EQ(tail.p99OfAll(), 990) << "number 989.01 from 0";
    EXPECT_NEAR(tail.p99(), (1000 + 1.0 / 3) * 0.99 + 1.0 / 3, 1e-9);
    EXPECT_EQ(tail.atRank(1, 1000), 1);
    EXPECT_EQ(tail.atRank(1000, 1000), 1000);
    EXPECT_EQ(tail.atRank(100, 100), 1000) << "of pixels that are worth a tenth";
    EXPECT_EQ(tail.atRank(99, 100), 990);
    EXPECT_EQ(Tail(ascending(1)).p99(), 1);
}

TEST(Tails, KnowTheNoiseByItsDouble) {
    // With twice the noise in their squares values are larger by its share.
    for (const double share : {0.0, 0.2, 0.4}) {
        const Tail tail(ascending(1000, std::sqrt(1 + share)));
        EXPECT_NEAR(tail.noiseShare(), share, 1e-3);
        EXPECT_NEAR(tail.withoutNoise(), std::sqrt(1 - share), 1e-3);
        EXPECT_NEAR(tail.cautiously(), std::sqrt(1 - share) * std::min(1.0, 2 - 2 * share / kMostNoise),
                    4e-3);
    }
    // At the extreme end alone, or below it: the larger one.
    std::vector<PixelError> end = ascending(1000);
    for (PixelError& e : end)
        if (e.shown && e.luv > 970)
            e.luvHalves = {1.1 * e.luv, 1.1 * e.luv};
    EXPECT_NEAR(Tail(end).noiseShare(), 0.21, 0.02);
    EXPECT_NEAR(Tail(end).withoutNoise(), std::sqrt(0.79), 0.02);
    std::vector<PixelError> below = ascending(1000);
    for (PixelError& e : below)
        if (e.shown && e.luv <= 970)
            e.luvHalves = {1.02 * e.luv, 1.02 * e.luv};
    EXPECT_NEAR(Tail(below).withoutNoise(), 1, 1e-2);
    EXPECT_GT(Tail(below).noiseShare(), 0.02);
}

// A thousand clusters of ten. Where the largest errors fill whole clusters they are worth a tenth, whichever
// of the percentiles that is.
TEST(Tails, ClustersThatErrAlikeAreWorthOnePixel) {
    for (const double share : {0.1, 0.05, 0.03, 0.02, 0.01}) {
        std::vector<PixelError> errors;
        for (int n = 0; n < 10000; ++n) {
            const int cluster = n / 10;
            const bool large = cluster < std::lround(1000 * share);
            const double spread = (n * 7919 % 10007) / 10007.0; // of none of its neighbours
            errors.push_back({cluster, true, 0, (large ? 2 : 0) + spread, 0, {}});
        }
        EXPECT_NEAR(tailDesignEffect(errors, Tail(errors), 1000), 10, 0.3) << share;
    }
    std::vector<PixelError> apart;
    for (int n = 0; n < 10000; ++n)
        apart.push_back({n % 1000, true, 0, (n * 7919 % 10007) / 10007.0, 0, {}});
    const double effect = tailDesignEffect(apart, Tail(apart), 1000);
    EXPECT_GE(effect, 1);
    EXPECT_LT(effect, 1.5);
}

} // namespace
} // namespace tessera

// tests/bench/contest_test.cpp: times at a target, from renderers whose errors and times are made up.
#include "tests/bench/contest.h"

#include "tests/bench/bench_tools.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>

namespace tessera::bench {
namespace {

Setting settingOf(double voxels, double rms, double luvP99, std::vector<double> ms) {
    Setting setting;
    setting.voxels = voxels;
    setting.error.rms = rms;
    setting.error.luvP99 = luvP99;
    setting.ms = std::move(ms);
    return setting;
}

const ErrorTarget kTarget{0.01, 3};

TEST(Contest, TimeLiesBetweenTheLastThatMissesAndTheFirstThatMeetsBoth) {
    Contender c;
    c.settings = {settingOf(2, 0.04, 12, {50}), settingOf(1, 0.02, 2, {100}),
                  settingOf(0.5, 0.005, 1, {400, 390})};
    const TimeAtTarget time = timeAt(c, kTarget, minimum);
    EXPECT_TRUE(time.reached);
    EXPECT_NEAR(time.ms, std::sqrt(100.0 * 390.0),
                1e-9); // 0.01 is half way from 0.02 to 0.005, in logarithms
    EXPECT_EQ(decidingSettings(c, kTarget, std::nullopt), (std::vector<std::size_t>{1, 2}));
}

TEST(Contest, TheLaterOfBothErrorsDecides) {
    Contender c;
    c.settings = {settingOf(1, 0.02, 12, {100}), settingOf(0.5, 0.005, 2.9, {400})};
    const double byLuv = 100 * std::pow(4, std::log(12 / 3.0) / std::log(12 / 2.9));
    EXPECT_NEAR(timeAt(c, kTarget, minimum).ms, byLuv, 1e-9);
    EXPECT_GT(byLuv, 200); // the time by rms alone
}

TEST(Contest, TimesOfOneRoundAreThatRoundsAlone) {
    Contender c;
    c.settings = {settingOf(1, 0.02, 0, {10, 40}), settingOf(0.5, 0.005, 0, {20, 80, 30})};
    const ErrorTarget target{0.01, 100}; // half way, log-log
    EXPECT_NEAR(timeAt(c, target, ofRound(0)).ms, std::sqrt(10 * 20.0), 1e-9);
    EXPECT_NEAR(timeAt(c, target, ofRound(1)).ms, std::sqrt(40 * 80.0), 1e-9);
    EXPECT_NEAR(timeAt(c, target, ofRound(2)).ms, std::sqrt(10 * 30.0), 1e-9); // the first one again
}

TEST(Contest, NothingIsExtrapolated) {
    Contender c;
    c.settings = {settingOf(1, 0.02, 2, {100}), settingOf(0.5, 0.011, 2, {200})};
    TimeAtTarget time = timeAt(c, kTarget, minimum);
    EXPECT_FALSE(time.reached);
    EXPECT_EQ(time.ms, 200);
    EXPECT_EQ(decidingSettings(c, kTarget, std::nullopt), (std::vector<std::size_t>{1}));
    c.settings = {settingOf(1, 0.001, 1, {100})}; // the coarsest is better already
    time = timeAt(c, kTarget, minimum);
    EXPECT_TRUE(time.reached);
    EXPECT_EQ(time.ms, 100);
}

TEST(Contest, ErrorsThatRiseAgainAreNotHeldAgainstARenderer) {
    Contender c; // VTK's CPU mapper is such a one
    c.settings = {settingOf(2, 0.030, 9, {50}), settingOf(1, 0.0205, 9, {90}),
                  settingOf(0.5, 0.020, 9, {180}), settingOf(0.25, 0.026, 9, {400})};
    EXPECT_EQ(cheapestOfBest(c), 1u);
}

TEST(Contest, ClimbsUntilTheTargetIsMetOrNothingIsGained) {
    // One pixel that is off by a share of the distance, down to a floor.
    const auto made = [](double floor) {
        auto voxelsNow = std::make_shared<double>(0);
        Contender c;
        c.draw = [voxelsNow](double voxels) {
            *voxelsNow = voxels;
            return 1 / voxels;
        };
        c.picture = [voxelsNow, floor] {
            Image image(glm::ivec2(1));
            image.pixels[0] =
                glm::vec4(glm::vec3(0.5f + static_cast<float>(std::max(0.1 * *voxelsNow, floor))), 1);
            return image;
        };
        return c;
    };
    Truth truth;
    truth.picture = Image(glm::ivec2(1));
    truth.picture.pixels[0] = glm::vec4(0.5f, 0.5f, 0.5f, 1);
    truth.leftOut = {false};
    const std::vector<double> distances = {4, 2, 1, 0.5, 0.25, 0.125, 0.0625};
    const ErrorTarget target{0.03, 100};
    Contender good = made(0), floored = made(0.1), slow = made(0);
    climb(good, distances, truth, target, {});
    ASSERT_EQ(good.settings.size(), 5u);
    EXPECT_EQ(good.settings.back().voxels, 0.25); // 0.022 rms of four components, one of them right
    climb(floored, distances, truth, target, {});
    EXPECT_EQ(floored.settings.back().voxels, 0.25); // two halvings after 1 gained nothing
    ContestLimits limits;
    limits.mostMs = 1.5;
    climb(slow, distances, truth, target, limits);
    EXPECT_EQ(slow.settings.back().voxels, 1);
    EXPECT_TRUE(slow.stoppedByTime);
}

TEST(Contest, RoundsGoForwardsAndBackwardsAndSpareSlowOnes) {
    std::string order;
    std::vector<Contender> contenders(2);
    for (std::size_t i = 0; i < 2; ++i) {
        contenders[i].settings = {settingOf(1, 0, 0, {})};
        contenders[i].draw = [&order, i](double) {
            order += i ? 'b' : 'a';
            return i ? 1000.0 : 1.0;
        };
    }
    ContestLimits limits;
    limits.rounds = 4;
    limits.shareMs = 1500;
    runRounds(contenders, {{0}, {0}}, limits);
    EXPECT_EQ(order, "abbaaa");
    EXPECT_EQ(contenders[1].settings[0].ms.size(), 2u);
}

} // namespace
} // namespace tessera::bench

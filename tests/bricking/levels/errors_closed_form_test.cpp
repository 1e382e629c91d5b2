// tests/bricking/levels/errors_closed_form_test.cpp: predicted errors of bricks, and the cost and gain of
// levels, where the answer is known without computing it. Rays are made by hand, and budgets have a single
// choice that uses them up.
#include "bricking/levels/level_error.h"
#include "bricking/levels/ray_compositing.h"
#include "tests/support/bricking_selection_tools.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using test::plainInfo;

/// Rays of one brick of unitInfo(): both parts the same.
BrickRays raysOfPart(const BrickRayPart& part) {
    BrickRays rays;
    rays.bricks = {1, 1, 1};
    rays.pages.emplace_back(BrickRays::kRowsPerPage * rays.rowBytes());
    rays.rowOf.push_back(static_cast<std::uint32_t>(rays.rows++));
    for (std::size_t n = 0; n < kBrickRayParts; ++n)
        encode(part, std::span<std::uint8_t, kBrickRayBytes>(rays.row(0).data() + n * kBrickRayBytes,
                                                             kBrickRayBytes));
    return rays;
}
std::size_t codeAt(int ray, int level, int sample) {
    int at = ray * kSamplesPerRay + sample;
    for (int l = 0; l < level; ++l)
        at += kRaySamples[static_cast<std::size_t>(l)];
    return static_cast<std::size_t>(at);
}

// The last ray of a part stands for a brick's extremes and counts a sixteenth, the other eleven share the
// rest.
TEST(Transmittance, IsTheWeightedMeanOfTheRays) {
    BrickRayPart part;
    part.lo = 0;
    part.hi = 255;
    for (int sample = 0; sample < kSamplesPerRay; ++sample)
        part.codes[codeAt(kRaysPerPart - 1, 0, sample)] = 255;
    const double extinction = 0.05; // over 32 mm
    const TransferTable table = makeTable(
        TransferFunction::fromExtinction({{0, 0}, {100, 0}, {200, extinction}, {255, extinction}}, {}));
    const LevelErrors e = rayErrors(raysOfPart(part), {1}, table, test::unitInfo({32, 32, 32}));
    EXPECT_NEAR(static_cast<double>(e.transmittances[0]), (15 + std::exp(-32 * extinction)) / 16, 1e-4);
}

// In the dark L* is a straight line: 24389/27 times a luminance of four thousandths, which coarser levels
// lose.
TEST(PredictErrors, OfDarkColoursAreStraight) {
    BrickRayPart part;
    part.lo = 0;
    part.hi = 255;
    for (int ray = 0; ray < kRaysPerPart; ++ray)
        for (int sample = 0; sample < 16; ++sample)
            part.codes[codeAt(ray, 0, sample)] = 255;
    const double luminance = 0.004, extinction = -std::log1p(-luminance) / 32;
    const TransferTable table = makeTable(
        TransferFunction::fromExtinction({{0, 0}, {100, 0}, {200, extinction}, {255, extinction}}, {}));
    const LevelErrors e = rayErrors(raysOfPart(part), {1}, table, test::unitInfo({32, 32, 32}));
    EXPECT_NEAR(static_cast<double>(e.errors[0][1]), 24389.0 / 27 * luminance, 0.01);
}

// Samples between those that are kept of a coarse level are interpolated to the nearest code: a finest level
// that has just these is matched without error.
TEST(PredictErrors, AreNothingWhereTheFinestLevelIsWhatIsInterpolated) {
    BrickRayPart part;
    part.lo = 0;
    part.hi = 255;
    for (int ray = 0; ray < kRaysPerPart; ++ray)
        for (int sample = 0; sample < 8; ++sample) {
            const auto kept = [&](int n) { return 40 + 17 * ((7 * std::clamp(n, 0, 7) + ray) % 8); };
            part.codes[codeAt(ray, 2, sample)] = static_cast<std::uint8_t>(kept(sample));
            for (const int side : {0, 1}) {
                const double exact = 0.75 * kept(sample) + 0.25 * kept(sample + (side == 0 ? -1 : 1));
                part.codes[codeAt(ray, 0, 2 * sample + side)] =
                    static_cast<std::uint8_t>(std::floor(exact + 0.5));
            }
        }
    const TransferTable table =
        makeTable(TransferFunction::fromExtinction({{0, 0}, {255, 0.1}}, {{0, {1, 0, 0}}, {255, {0, 0, 1}}}));
    const LevelErrors e = rayErrors(raysOfPart(part), {1}, table, test::unitInfo({32, 32, 32}));
    EXPECT_EQ(e.errors[0][2], 0);
    EXPECT_GT(e.errors[0][3], 1); // of which nothing was kept
}

// A ramp from entry to entry: its integral is a parabola, beyond the table a straight line.
TEST(FunctionSums, IntegrateExactly) {
    const TransferTable table = makeTable(TransferFunction::fromExtinction({{0, 0}, {255, 255}}, {}));
    ASSERT_EQ(table.entries.size(), 256u);
    const FunctionSums sums(table);
    EXPECT_DOUBLE_EQ(sums.lastPlace(), 255);
    for (const double place : {0.0, 0.25, 1.0, 17.5, 254.75, 255.0})
        EXPECT_NEAR(sums.upTo(place).a, 0.5 * place * place, 1e-9 * place * place) << place;
    EXPECT_NEAR(sums.upTo(265).a, 0.5 * 255 * 255 + 10 * 255, 1e-6);
    EXPECT_EQ(sums.upTo(-10).a, 0);
}

// Functions are as narrow for a volume whose slope is negative.
TEST(IsNarrow, KnowsNoSign) {
    VolumeInfo info = plainInfo({32, 32, 32}, ValueType::f32);
    const TransferTable table =
        makeTable(TransferFunction::fromExtinction({{0, 0}, {499, 0}, {500, 1}, {501, 0}, {1000, 0}}, {}));
    const FunctionSums sums(table);
    const std::vector<float> ranges = {1000};
    for (const double slope : {1.0, -1.0}) {
        info.rescaleSlope = slope;
        EXPECT_TRUE(isNarrow(sums, table, info, ranges)) << slope;
    }
}

/// `count` bricks of weight 1 that all have these errors.
void addBricks(LevelErrors& e, ViewWeights& w, int count, const std::array<float, kLevelCount>& errors) {
    for (int n = 0; n < count; ++n) {
        e.errors.push_back(errors);
        e.shows.push_back(1);
        w.area.push_back(1);
        w.finest.push_back(0);
    }
    e.bricks = w.bricks = {static_cast<int>(e.shows.size()), 1, 1};
}
std::size_t bricksAt(const Selection& s, int level) {
    return s.counts[static_cast<std::size_t>(level)];
}

// 300 bricks get to level 1 first and then to level 0: the pages that they leave on the way are free again.
TEST(SelectLevels, UsesThePagesThatBricksLeave) {
    LevelErrors e;
    ViewWeights w;
    addBricks(e, w, 300, {0, 1, 10, 10, 10, 10});
    const Selection s = selectLevels(e, w, std::vector<float>(300), 300);
    EXPECT_EQ(bricksAt(s, 0), 300u);
}

// A page holds eight bricks of level 1, which gain 1 each, or one of level 0, which gains 6.
TEST(SelectLevels, BuysWhatGainsMostPerPage) {
    LevelErrors e;
    ViewWeights w;
    addBricks(e, w, 2400, {0, 0, 1, 1, 1, 1});
    addBricks(e, w, 300, {0, 6, 6, 6, 6, 6});
    const Selection s = selectLevels(e, w, std::vector<float>(2700), 300);
    EXPECT_EQ(bricksAt(s, 1), 2400u);
    EXPECT_EQ(bricksAt(s, 0), 0u);
}

} // namespace
} // namespace tessera

// Statistics of pixels that were drawn again: known values of distributions and ranks, and the share of
// intervals that contain the truth. Fields have known errors in clusters and with long tails, and many
// choices of pixels are tried.
#include "core/image/colour.h"
#include "core/image/image_metrics.h"
#include "render/verify/error_goal.h"
#include "render/verify/intervals.h"
#include "render/verify/measured_errors.h"
#include "render/verify/pixel_sample.h"

#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <numbers>

namespace tessera {
namespace {

TEST(Distributions, HaveTheirKnownValues) {
    EXPECT_NEAR(incompleteBeta(2, 3, 0.4), 0.5248, 1e-12); // 1 - 0.6^4 - 4 0.4 0.6^3
    EXPECT_NEAR(incompleteBeta(0.5, 0.5, 0.3), 2 / std::numbers::pi * std::asin(std::sqrt(0.3)), 1e-12);
    EXPECT_NEAR(binomialAtMost(3, 10, 0.5), 176.0 / 1024, 1e-12);
    EXPECT_NEAR(binomialAtMost(298, 299, 0.99), 1 - std::pow(0.99, 299), 1e-12);
    EXPECT_NEAR(studentQuantile(0.975, 1), 12.7062047364, 1e-8); // tables of Student's t
    EXPECT_NEAR(studentQuantile(0.975, 10), 2.2281388520, 1e-8);
    EXPECT_NEAR(studentQuantile(0.95, 30), 1.6972608943, 1e-8);
    EXPECT_NEAR(studentQuantile(0.975, 500), 1.9647198374, 1e-8);
}

/// P(B <= k), term by term.
double summed(int k, int n, double chance) {
    double term = std::pow(1 - chance, n), sum = 0;
    for (int i = 0; i <= k; ++i) {
        sum += term;
        term *= chance / (1 - chance) * (n - i) / (i + 1);
    }
    return sum;
}

// What is known of sums: a constant that all have changes neither, and their unit comes out squared and
// cubed. Skewness turns round with the errors' sign, and draws the interval out to its side.
TEST(ClusterSums, HaveTheirMoments) {
    const auto of = [](double unit, double constant) {
        ClusterSums sums(8);
        const double v[] = {0, 1, 0, 2, 1, 9, 0, 1};
        for (int n = 0; n < 8; ++n)
            for (const double part : {0.25, 0.75}) // added up
                sums.add(n, part * (unit * v[n] + constant));
        return sums;
    };
    const ClusterSums plain = of(1, 0);
    EXPECT_EQ(plain.strata(), 4);
    EXPECT_NEAR(plain.variance(), 1 + 4 + 64 + 1, 1e-12);
    // about the mean, 1.75
    EXPECT_NEAR(plain.thirdMoment(),
                3 * std::pow(-1.75, 3) + 3 * std::pow(-0.75, 3) + std::pow(0.25, 3) + std::pow(7.25, 3),
                1e-9);
    for (const double unit : {0.5, 3.0, -1.0})
        for (const double constant : {0.0, 5.0, -40.0}) {
            EXPECT_NEAR(of(unit, constant).variance(), unit * unit * plain.variance(), 1e-8);
            EXPECT_NEAR(of(unit, constant).thirdMoment(), std::pow(unit, 3) * plain.thirdMoment(), 1e-6);
        }
    const Interval right = clusterInterval(10, plain, 0), left = clusterInterval(10, of(-1, 0), 0);
    EXPECT_NEAR(right.high - 10, 10 - left.low, 1e-9);
    EXPECT_NEAR(10 - right.low, left.high - 10, 1e-9);
    EXPECT_GT(right.high - 10, 1.2 * (10 - right.low));
    EXPECT_NEAR(clusterInterval(10, plain, 2).high, right.high + 2, 1e-12);
    EXPECT_EQ(clusterInterval(10, plain, 2).low, right.low);
}

TEST(QuantileBounds, AreWilksNumbers) {
    EXPECT_FALSE(rankAbove(298, 0.99, 0.95));
    EXPECT_EQ(rankAbove(299, 0.99, 0.95), 299);
    EXPECT_EQ(rankAbove(472, 0.99, 0.95), 472); // one value above is allowed from 473 on, two from 628
    EXPECT_EQ(rankAbove(473, 0.99, 0.95), 472);
    EXPECT_EQ(rankAbove(627, 0.99, 0.95), 626);
    EXPECT_EQ(rankAbove(628, 0.99, 0.95), 626);
    EXPECT_EQ(rankAbove(59, 0.95, 0.95), 59);
    for (const int n : {60, 100, 150}) {
        const int high = *rankAbove(n, 0.9, 0.975), low = *rankBelow(n, 0.9, 0.975);
        EXPECT_GE(summed(high - 1, n, 0.9), 0.975);
        EXPECT_LT(summed(high - 2, n, 0.9), 0.975);
        EXPECT_LE(summed(low - 1, n, 0.9), 0.025);
        EXPECT_GT(summed(low, n, 0.9), 0.025);
    }
    EXPECT_FALSE(ranksAround(298, 0.99, 0.95));
    for (const int n : {305, 340, 367, 368, 1000}) { // 305: the upper end takes nearly all that is left
        const QuantileRanks ranks = *ranksAround(n, 0.99, 0.95);
        EXPECT_GE(binomialAtMost(ranks.high - 1, n, 0.99) - binomialAtMost(ranks.low - 1, n, 0.99), 0.95);
    }
}

double normal(RandomNumbers& random) {
    const double radius = std::sqrt(-2 * std::log(1 - random.unit()));
    return radius * std::cos(2 * std::numbers::pi * random.unit());
}

struct Field {
    Image picture, truth;
    double noise; // standard deviation of one replicate's components
};

/// Errors of squares of pixels are alike, of a log-normal size; part of the picture shows nothing.
Field fieldOf(int side, int square, double spread, double noise) {
    Field f{Image({side, side}), Image({side, side}), noise};
    std::vector<double> sizes;
    RandomNumbers random(17);
    for (int i = 0; i < (side / square + 1) * (side / square + 1); ++i)
        sizes.push_back(std::min(0.3, 0.004 * std::exp(spread * normal(random))));
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            if (x + y < side / 2)
                continue; // an eighth of the picture
            const double size =
                sizes[static_cast<std::size_t>(y / square * (side / square + 1) + x / square)];
            const auto error = static_cast<float>(size * (0.7 + 0.6 * random.unit()));
            f.truth.at(x, y) = glm::vec4(0.4f, 0.45f, 0.35f, 1);
            f.picture.at(x, y) = f.truth.at(x, y) + error * glm::vec4(1, 0.8f, 1.1f, -0.2f);
        }
    return f;
}

MeasuredErrors measured(const Field& field, const SampleDesign& design, int replicates, RandomNumbers& random,
                        int round = 0, double boundChance = 0.95) {
    PixelPairs pairs;
    pairs.sample = choosePixels(field.truth.size, design, round);
    pairs.replicates = replicates;
    for (const SampledPixel& p : pairs.sample.pixels) {
        const glm::vec4 truth = field.truth.at(p.at.x, p.at.y);
        pairs.picture.push_back(field.picture.at(p.at.x, p.at.y));
        for (int r = 0; r < replicates; ++r) {
            glm::vec4 noisy = truth;
            for (int c = 0; c < 4 && truth.a > 0 && field.noise > 0; ++c)
                noisy[c] += static_cast<float>(field.noise * normal(random));
            pairs.truth.push_back(noisy);
        }
    }
    return measuredErrors(pairs, 0, boundChance);
}

/// Shares of the trials that hold the truth, and what is said in the mean.
struct Coverage {
    double rms = 0, mean = 0, p99 = 0, bound = 0; // shares
    double p99Said = 0, boundSaid = 0;            // shares of the trials that said any
    double square = 0, luv = 0, p99Value = 0;     // against the truth
    double rmsWidth = 0, p99Width = 0, boundValue = 0;

    Coverage(const Field& field, const SampleDesign& design, int replicates, int trials) {
        const ImageError is = measureError(field.picture, field.truth);
        const double each = 1.0 / trials;
        const auto holds = [](const Estimate& e, double truth) { return e.low <= truth && truth <= e.high; };
        RandomNumbers random(5);
        for (int trial = 0; trial < trials; ++trial) {
            SampleDesign d = design;
            d.seed = static_cast<std::uint64_t>(trial);
            const MeasuredErrors m = measured(field, d, replicates, random);
            rms += holds(*m.rms, is.rmse) ? each : 0;
            mean += holds(*m.luvMean, is.luvMean) ? each : 0;
            square += each * m.rms->value * m.rms->value / (is.rmse * is.rmse);
            luv += each * m.luvMean->value / is.luvMean;
            rmsWidth += each * (m.rms->high - m.rms->low) / is.rmse;
            if (m.luvP99) {
                p99Said += each;
                p99 += holds(*m.luvP99, is.luvP99) ? each : 0;
                p99Value += each * m.luvP99->value / is.luvP99;
                p99Width += each * (m.luvP99->high - m.luvP99->low) / is.luvP99;
            }
            if (m.luvP99Bound) {
                boundSaid += each;
                bound += is.luvP99 <= *m.luvP99Bound ? each : 0;
                boundValue += each * *m.luvP99Bound / is.luvP99;
            }
        }
    }
};

TEST(MeasuredErrors, HoldTheTruth) {
    const Field field = fieldOf(256, 8, 0.7, 0);
    const Coverage c(field, {1000, 1, 4}, 1, 400);
    EXPECT_GE(c.rms, 0.93);
    EXPECT_GE(c.mean, 0.93);
    EXPECT_NEAR(c.p99Said, 1, 1e-9) << "whether there is a number must not depend on the errors";
    EXPECT_GE(c.p99, 0.94);
    EXPECT_GE(c.bound, 0.94);
    EXPECT_LT(c.bound, 0.995) << "looser than need be";
    EXPECT_NEAR(c.square, 1, 0.02);
    EXPECT_NEAR(c.luv, 1, 0.01);
    EXPECT_NEAR(c.p99Value, 1, 0.1);
    EXPECT_LT(c.rmsWidth, 0.6);
    EXPECT_LT(c.p99Width, 1);
    EXPECT_LT(c.boundValue, 1.6);
}

// Whoever draws pixels until a bound is low enough takes the luckiest: asked for more each time, the first
// that is low enough still holds. The picture errs by a little more than is certified.
TEST(MeasuredErrors, HoldWhereTheFirstBoundThatIsLowEnoughCounts) {
    const Field field = fieldOf(256, 8, 0.7, 0);
    const double wanted = 0.999 * measureError(field.picture, field.truth).luvP99;
    RandomNumbers random(5);
    constexpr int kTrials = 300, kAttempts = 5;
    int wrong = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
        bool certified = false;
        for (int attempt = 0; attempt < kAttempts && !certified; ++attempt)
            certified = *measured(field, {1000, 1, 4, static_cast<std::uint64_t>(trial)}, 1, random, attempt,
                                  chanceOfAttempt(attempt))
                             .luvP99Bound <= wanted;
        wrong += certified;
    }
    EXPECT_LE(wrong, 0.05 * kTrials);
}

// Eight pixels of a cluster have nearly one error: they say little more than one of them.
TEST(MeasuredErrors, HoldTheTruthWhereClustersErrAlike) {
    const Field field = fieldOf(256, 16, 0.8, 0);
    const Coverage c(field, {2800, 8, 12}, 1, 300);
    EXPECT_GE(c.rms, 0.92);
    EXPECT_GE(c.mean, 0.92);
    EXPECT_NEAR(c.p99Said, 1, 1e-9);
    EXPECT_GE(c.p99, 0.92);
    EXPECT_GE(c.bound, 0.94);
    EXPECT_LT(c.rmsWidth, 0.7);
}

// The truth's noise is as large as many errors are: squares, means and percentiles say what they are without
// it.
TEST(MeasuredErrors, AreThoseWithoutTheTruthsNoise) {
    for (const int replicates : {2, 4}) {
        const Field field = fieldOf(256, 4, 0.7, 0.0035 * std::sqrt(replicates / 4.0));
        const Coverage c(field, {1000, 1, 4}, replicates, 200);
        SCOPED_TRACE(replicates);
        EXPECT_NEAR(c.square, 1, 0.03);
        EXPECT_NEAR(c.luv, 1, 0.06);
        EXPECT_GE(c.rms, 0.92);
        EXPECT_GE(c.mean, 0.92);
        EXPECT_NEAR(c.p99Said, 1, 1e-9);
        EXPECT_GE(c.p99, 0.92);
        EXPECT_NEAR(c.p99Value, 1, 0.1);
    }
}

// If they are alike in kind, here normal, taking out the noise leaves nothing of it: a fourth of the squares.
TEST(MeasuredErrors, HaveNoNoiseLeftThatIsLikeTheErrors) {
    Field field = fieldOf(256, 8, 0, 0);
    RandomNumbers random(3);
    constexpr double kError = 0.004;
    for (std::size_t i = 0; i < field.picture.pixels.size(); ++i)
        for (int c = 0; c < 4; ++c)
            field.picture.pixels[i][c] =
                field.truth.pixels[i][c] + static_cast<float>(kError * normal(random));
    field.noise = kError * std::sqrt(4 / 3.0); // of four replicates' mean: a third of the error's square
    const Coverage c(field, {1000, 1, 4}, 4, 200);
    EXPECT_NEAR(c.square, 1, 0.01);
    EXPECT_NEAR(c.luv, 1, 0.01);
    EXPECT_NEAR(c.p99Said, 1, 1e-9);
    EXPECT_NEAR(c.p99Value, 1, 0.03);
    EXPECT_GE(c.p99, 0.95);
    EXPECT_GE(c.boundValue, 1.1) << "a bound keeps the noise";
}

TEST(MeasuredErrors, OfATruthOfNoiseAloneSayOnlyABound) {
    const Field field = fieldOf(128, 8, 0.5, 0.1);
    RandomNumbers random(1);
    const MeasuredErrors m = measured(field, {1000, 1, 4, 1}, 4, random);
    EXPECT_FALSE(m.luvP99);
    EXPECT_EQ(m.whyNoP99, NotMeasured::truthTooNoisy);
    EXPECT_TRUE(m.luvP99Bound);
    EXPECT_LT(m.rms->low, 0.01);
}

TEST(MeasuredErrors, OfFewPixelsSayNoPercentile) {
    const Field field = fieldOf(128, 8, 1.0, 0);
    RandomNumbers random(1);
    const MeasuredErrors few = measured(field, {298, 1, 4, 1}, 1, random);
    EXPECT_LT(few.shown, 298); // an eighth shows nothing
    EXPECT_TRUE(few.rms && few.luvMean);
    EXPECT_FALSE(few.luvP99 || few.luvP99Bound);
    EXPECT_EQ(few.whyNoP99, NotMeasured::tooFewPixels);
    EXPECT_FALSE(measured(field, {100, 1, 4, 1}, 1, random).rms); // an eighth shows nothing
    EXPECT_FALSE(measured(field, {400, 10, 16, 1}, 1, random).luvMean) << "40 clusters";
    // Many pixels of few clusters are few.
    const MeasuredErrors clustered = measured(field, {2000, 8, 12, 1}, 1, random);
    EXPECT_FALSE(clustered.luvP99 || clustered.luvP99Bound);
    EXPECT_EQ(clustered.whyNoP99, NotMeasured::tooFewPixels);
}

// Nothing is left to chance: what is measured is what the picture errs by.
TEST(MeasuredErrors, OfAllPixelsAreExact) {
    const Field field = fieldOf(32, 4, 1.0, 0);
    const ImageError is = measureError(field.picture, field.truth);
    RandomNumbers random(1);
    const MeasuredErrors m = measured(field, {1000, 1, 4, 1}, 1, random);
    EXPECT_EQ(m.pixels, 1024);
    for (const auto& [e, truth] :
         {std::pair(*m.rms, is.rmse), std::pair(*m.luvMean, is.luvMean), std::pair(*m.luvP99, is.luvP99)}) {
        EXPECT_NEAR(e.value, truth, 1e-9 * truth);
        EXPECT_NEAR(e.high - e.low, 0, 1e-9 * truth);
    }
    EXPECT_NEAR(*m.luvP99Bound, is.luvP99, 1e-9);
}

TEST(MeasuredErrors, OfAllPixelsHaveOnlyTheTruthsNoise) {
    const Field field = fieldOf(32, 4, 0.7, 0.0015);
    const Coverage all(field, {1000, 1, 4}, 4, 10), some(field, {400, 1, 4}, 4, 10);
    EXPECT_GE(all.rms, 0.9);
    EXPECT_GE(all.mean, 0.9);
    EXPECT_GE(all.p99, 0.9);
    EXPECT_LT(all.rmsWidth, 0.3 * some.rmsWidth);
}

TEST(MeasuredErrors, OfPixelsThatAreNotFiniteAreAsMeasureErrorHasThem) {
    Field field = fieldOf(16, 4, 1.0, 0);
    field.picture.at(12, 12) = glm::vec4(std::numeric_limits<float>::quiet_NaN());
    const ImageError is = measureError(field.picture, field.truth);
    RandomNumbers random(1);
    const MeasuredErrors m = measured(field, {1000, 1, 4, 1}, 2, random);
    EXPECT_NEAR(m.rms->value, is.rmse, 1e-9);
    EXPECT_NEAR(m.luvMean->value, is.luvMean, 1e-9);
}

MeasuredErrors errorOf(double value, double bound) {
    MeasuredErrors e;
    e.luvP99 = Estimate{value, 0.5 * value, bound};
    e.luvP99Bound = bound;
    return e;
}

// The bound decides, not the value; what is made finer is what errs; and it ends, with a reason.
TEST(ErrorGoal, GoesOnUntilTheBoundIsWithinIt) {
    using Verdict = ErrorGoal::Verdict;
    ErrorGoal goal(3);
    const double rays = goal.ofRays(), samples = goal.ofSamples();
    EXPECT_EQ(goal.judge(errorOf(2, 4), errorOf(2, 4), errorOf(0.1, 0.2), false, false), Verdict::goOn);
    EXPECT_EQ(goal.ofRays(), rays) << "levels and steps err by little";
    EXPECT_LT(goal.ofSamples(), 0.8 * samples);
    EXPECT_EQ(goal.judge(errorOf(2, 3), errorOf(2, 3), errorOf(0.1, 0.2), false, false), Verdict::reached);
    EXPECT_EQ(goal.shortfall(), "");

    ErrorGoal coarse(3);
    EXPECT_EQ(coarse.judge(errorOf(9, 12), errorOf(0.1, 0.3), errorOf(9, 12), false, false), Verdict::goOn);
    EXPECT_LT(coarse.ofRays(), 0.3 * rays) << "a prediction that was wrong by four";
    EXPECT_EQ(coarse.ofSamples(), samples);
    EXPECT_EQ(coarse.judge(errorOf(9, 12), errorOf(0.1, 0.3), errorOf(9, 12), true, false),
              Verdict::notReached);
    EXPECT_NE(coarse.shortfall().find("no level or step is finer"), std::string::npos);

    ErrorGoal endless(3);
    int rounds = 1;
    while (endless.judge(errorOf(4, 5), errorOf(4, 5), errorOf(4, 5), false, false) == Verdict::goOn)
        ++rounds;
    EXPECT_EQ(rounds, ErrorGoal::kMostRounds);
    EXPECT_FALSE(endless.shortfall().empty());
}

// What is made finer: half of the bound's excess at once, by no more than ten times, and by no less than 0.7.
TEST(ErrorGoal, CorrectsByHalfOfWhatIsTooMuch) {
    const auto corrected = [](double high, bool ofRays) {
        ErrorGoal goal(2);
        const double rays = goal.ofRays(), samples = goal.ofSamples();
        EXPECT_NEAR(rays, 0.7 * 2, 1e-12);
        EXPECT_NEAR(samples, 2.0 / 3, 1e-12);
        const MeasuredErrors errs = errorOf(high, high), small = errorOf(0.1, 0.2);
        EXPECT_EQ(goal.judge(errs, ofRays ? small : errs, ofRays ? errs : small, false, false),
                  ErrorGoal::Verdict::goOn);
        EXPECT_EQ(ofRays ? goal.ofSamples() : goal.ofRays(), ofRays ? samples : rays);
        return ofRays ? goal.ofRays() / rays : goal.ofSamples() / samples;
    };
    for (const bool ofRays : {true, false}) {
        EXPECT_NEAR(corrected(4, ofRays), 0.25, 1e-9);
        EXPECT_NEAR(corrected(2.01, ofRays), 0.5 * 2 / 2.01, 1e-9);
        EXPECT_NEAR(corrected(100, ofRays), 0.1, 1e-9);
    }
    // A cause counts from half of what is asked on; where none does, both are made finer.
    const auto both = [](double samples, double rays) {
        ErrorGoal goal(2);
        const double r = goal.ofRays(), s = goal.ofSamples();
        EXPECT_EQ(goal.judge(errorOf(3, 3), errorOf(samples, samples), errorOf(rays, rays), false, false),
                  ErrorGoal::Verdict::goOn);
        return std::pair(goal.ofSamples() / s, goal.ofRays() / r);
    };
    EXPECT_EQ(both(1.01, 1).second, 1);
    EXPECT_NEAR(both(1.01, 1).first, 0.7, 1e-9) << "0.99, held to 0.7";
    EXPECT_EQ(both(1, 1.01).first, 1);
    EXPECT_EQ(both(1, 1).first, both(1, 1).second);
    EXPECT_NEAR(both(1, 1).first, 0.7, 1e-9);
    EXPECT_NEAR(both(1.6, 2.5).first, 0.625, 1e-9);
    EXPECT_NEAR(both(1.6, 2.5).second, 0.4, 1e-9);
    // At the bound it is reached, a hair above not.
    ErrorGoal goal(2);
    EXPECT_EQ(goal.judge(errorOf(1, 2), errorOf(1, 2), errorOf(1, 2), true, true),
              ErrorGoal::Verdict::reached);
    EXPECT_EQ(goal.judge(errorOf(1, 2.001), errorOf(1, 2), errorOf(1, 2), true, true),
              ErrorGoal::Verdict::notReached);
    EXPECT_NE(goal.shortfall().find("no level or step is finer"), std::string::npos);
    EXPECT_EQ(goal.judge(errorOf(1, 2.001), errorOf(1, 2), errorOf(0.1, 0.2), true, true),
              ErrorGoal::Verdict::notReached);
    EXPECT_NE(goal.shortfall().find("no pixel can get more samples"), std::string::npos);
    // Nothing is known of the error: by the least correction.
    MeasuredErrors unknown;
    EXPECT_EQ(goal.judge(unknown, unknown, unknown, false, false), ErrorGoal::Verdict::goOn);
    EXPECT_NEAR(goal.ofRays(), 0.7 * 0.7 * 2, 1e-12);
    EXPECT_NE(goal.shortfall().find("could not be measured"), std::string::npos);
}

// The ends of an interval are where Hall's transformed T is the quantile of Student's t.
TEST(ClusterSums, IntervalsInvertHallsTransform) {
    for (const double unit : {1.0, -0.4})
        for (const int clusters : {8, 40}) {
            ClusterSums sums(clusters);
            for (int n = 0; n < clusters; ++n)
                sums.add(n, unit * (n % 7 == 3 ? 4 : 0.3 * (n % 3)));
            const double error = std::sqrt(sums.variance()), g = sums.thirdMoment() / (error * error * error);
            const double t = studentQuantile(0.975, clusters / 2);
            const Interval found = clusterInterval(7, sums, 0);
            const auto transformed = [&](double T) {
                return T + g * T * T / 3 + g * g * T * T * T / 27 + g / 6;
            };
            // Of both ends the one to which errors are drawn out is further than t, the other is t itself.
            const double low = (found.low - 7) / error, high = (found.high - 7) / error;
            EXPECT_NEAR(unit > 0 ? transformed(-high) : transformed(-low), unit > 0 ? -t : t, 1e-6);
            EXPECT_NEAR(unit > 0 ? low : high, unit > 0 ? -t : t, 1e-6);
        }
}

// A pixel's error: squares less the variance of the truth's mean; colours by halves of what was drawn again.
TEST(PixelErrorsOfPairs, AreThoseOfTheirFormula) {
    RandomNumbers random(4);
    for (const int replicates : {1, 2, 4, 6, 8}) {
        PixelPairs pairs;
        pairs.replicates = replicates;
        for (int i = 0; i < 9; ++i) {
            pairs.sample.pixels.push_back({{i, 2 * i}, i / 2});
            const auto any = [&](double most) {
                glm::vec4 v;
                for (int c = 0; c < 4; ++c)
                    v[c] = static_cast<float>(most * random.unit());
                return v;
            };
            const glm::vec4 truth = any(1.1);
            pairs.picture.push_back(truth + any(0.2));
            for (int r = 0; r < replicates; ++r)
                pairs.truth.push_back(truth + any(0.1));
        }
        const std::vector<PixelError> found = pixelErrors(pairs, 0.6f);
        ASSERT_EQ(found.size(), 9u);
        const auto luv = [](const glm::dvec4& v) {
            return luvFromLinear(glm::clamp(glm::dvec3(v), 0.0, 1.0));
        };
        for (std::size_t i = 0; i < 9; ++i) {
            const glm::dvec4 picture(pairs.picture[i]);
            const glm::vec4* const drawn = &pairs.truth[i * static_cast<std::size_t>(replicates)];
            const auto meanOf = [&](const std::vector<int>& which) {
                glm::dvec4 sum(0);
                for (const int r : which)
                    sum += glm::dvec4(drawn[r]) / static_cast<double>(which.size());
                return sum;
            };
            std::vector<int> all;
            for (int r = 0; r < replicates; ++r)
                all.push_back(r);
            const glm::dvec4 mean = meanOf(all);
            double squares = 0;
            for (int c = 0; c < 4; ++c) {
                double variance = 0; // of the mean
                for (int r = 0; r < replicates && replicates > 1; ++r)
                    variance += std::pow(drawn[r][c] - mean[c], 2) / (replicates * (replicates - 1.0));
                squares += (std::pow(picture[c] - mean[c], 2) - variance) / 4;
            }
            EXPECT_EQ(found[i].cluster, static_cast<int>(i / 2));
            EXPECT_EQ(found[i].shown, mean.a > static_cast<double>(0.6f));
            EXPECT_NEAR(found[i].square, squares, 1e-9);
            EXPECT_NEAR(found[i].luv, glm::length(luv(picture) - luv(mean)), 1e-9);
            // All pairs of quarters, or both halves.
            std::vector<glm::dvec4> halves;
            if (replicates == 1)
                halves = {mean};
            else if (replicates % 4 != 0)
                for (int h = 0; h < 2; ++h) {
                    std::vector<int> which;
                    for (int r = 0; r < replicates / 2; ++r)
                        which.push_back(h * replicates / 2 + r);
                    halves.push_back(meanOf(which));
                }
            else
                for (int a = 0; a < 4; ++a)
                    for (int b = a + 1; b < 4; ++b) {
                        std::vector<int> which;
                        for (int r = 0; r < replicates; ++r)
                            if (r / (replicates / 4) == a || r / (replicates / 4) == b)
                                which.push_back(r);
                        halves.push_back(meanOf(which));
                    }
            ASSERT_EQ(found[i].luvHalves.size(), halves.size());
            double noisier = 0;
            for (std::size_t h = 0; h < halves.size(); ++h) {
                EXPECT_NEAR(found[i].luvHalves[h], glm::length(luv(picture) - luv(halves[h])), 1e-9);
                noisier += found[i].luvHalves[h] / static_cast<double>(halves.size());
            }
            EXPECT_NEAR(found[i].luvNoisier, noisier, 1e-9);
        }
    }
}

} // namespace
} // namespace tessera

// tests/core/base/lower_envelope_test.cpp: distances along a line against all pairs.
#include "core/base/lower_envelope.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace tessera {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

std::vector<double> byAllPairs(const std::vector<double>& f, double step) {
    std::vector<double> out(f.size(), kNone);
    for (std::size_t i = 0; i < f.size(); ++i)
        for (std::size_t j = 0; j < f.size(); ++j) {
            const double away = (static_cast<double>(i) - static_cast<double>(j)) * step;
            out[i] = std::min(out[i], away * away + f[j]);
        }
    return out;
}

TEST(LowerEnvelope, IsTheLeastOfAllPairs) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> height(0, 60), share(0, 1);
    LowerEnvelope envelope; // one for all: what is left of a longer line must not matter
    for (int run = 0; run < 400; ++run) {
        std::vector<double> f(1 + random() % 40);
        const double points = share(random), step = 0.2 + 3 * share(random);
        for (double& value : f)
            value = share(random) < points ? height(random) * (run % 3) : kNone;
        const std::vector<double> expected = byAllPairs(f, step);
        envelope.transform(f, step);
        for (std::size_t i = 0; i < f.size(); ++i)
            if (std::isinf(expected[i])) {
                ASSERT_EQ(f[i], kNone) << run;
            } else {
                ASSERT_NEAR(f[i], expected[i], 1e-9 * (1 + expected[i])) << run << " " << i;
            }
    }
}

TEST(LowerEnvelope, OneEndReachesTheOther) {
    for (const std::size_t at : {0u, 9u}) {
        std::vector<double> f(10, kNone);
        f[at] = 2;
        LowerEnvelope().transform(f, 0.5);
        EXPECT_DOUBLE_EQ(f[9 - at], 2 + 0.25 * 81);
        EXPECT_DOUBLE_EQ(f[at], 2);
    }
}

} // namespace
} // namespace tessera

// The reference as an integrator of analytic fields: closed forms T1 to T8 to 1e-12, over stiff extinction
// too.
#include "render/backends/reference/reference_integrator.h"

#include <gtest/gtest.h>
#include <numbers>

namespace tessera {
namespace {

/// Relative where the value is below one, with the room that rounding of a sum of panels needs.
constexpr double kTolerance = 1e-12;

template <typename F> ReferenceIntegrator over(double a, double b, const F& f, int pieces = 1) {
    ReferenceIntegrator integral;
    for (int i = 0; i < pieces; ++i)
        integral.add(a + (b - a) * i / pieces, a + (b - a) * (i + 1) / pieces, f);
    return integral;
}

TEST(ReferenceIntegrator, T1ConstantSlabOverTwelveDecades) {
    for (double sigma = 1e-6; sigma <= 1e6; sigma *= 10) {
        const auto r = over(0, 1, [&](double) { return RadiantPoint{sigma, glm::dvec3(1)}; });
        const double exact = -std::expm1(-sigma);
        EXPECT_NEAR(r.alpha(), exact, kTolerance * exact) << sigma;
        EXPECT_NEAR(r.colour().r, exact, kTolerance * exact) << sigma;
    }
}

TEST(ReferenceIntegrator, T3ExponentialSlab) {
    const double sigma0 = 3, h = 0.2, length = 2;
    const auto r = over(0, length, [&](double t) {
        return RadiantPoint{sigma0 * std::exp(-t / h), glm::dvec3(1)};
    });
    EXPECT_NEAR(r.depth(), sigma0 * h * -std::expm1(-length / h), kTolerance);
}

TEST(ReferenceIntegrator, T4SphereChords) {
    const double sigma = 0.7, radius = 2;
    for (const double b : {0.0, 0.5, 1.0, 1.9, 1.999}) {
        const double half = std::sqrt(radius * radius - b * b);
        const auto r = over(-half, half, [&](double) { return RadiantPoint{sigma, glm::dvec3(0.5)}; });
        EXPECT_NEAR(r.alpha(), -std::expm1(-2 * sigma * half), kTolerance);
        EXPECT_NEAR(r.colour().g, 0.5 * r.alpha(), kTolerance);
    }
}

TEST(ReferenceIntegrator, T5GaussianBlob) {
    const double sigma0 = 5, s = 0.3, h = 2;
    for (const double b : {0.0, 0.4, 1.0}) {
        const auto r = over(-h, h, [&](double t) {
            return RadiantPoint{sigma0 * std::exp(-(t * t + b * b) / (2 * s * s)), glm::dvec3(1)};
        });
        const double exact = sigma0 * s * std::sqrt(2 * std::numbers::pi) * std::exp(-b * b / (2 * s * s)) *
                             std::erf(h / (s * std::numbers::sqrt2));
        EXPECT_NEAR(r.depth(), exact, kTolerance * std::max(1.0, exact)) << b;
    }
}

TEST(ReferenceIntegrator, T6ColourRampOverStiffness) {
    const double c0 = 0.2, c1 = 0.9;
    for (double x = 1e-6; x <= 1e6; x *= 10) { // optical depth of the slab
        const auto r = over(0, 1, [&](double t) { return RadiantPoint{x, glm::dvec3(c0 + (c1 - c0) * t)}; });
        const double t = std::exp(-x);
        double ramp = -std::expm1(-x) / x - t;
        if (x < 0.5) { // the same by its series, sum of (-1)^(k+1) x^k k/(k+1)!, free of cancellation
            ramp = 0;
            double term = 1; // x^k / (k+1)!, signed
            for (int k = 1; k < 24; ++k) {
                term *= -x / (k + 1);
                ramp -= term * k;
            }
        }
        const double exact = c0 * -std::expm1(-x) + (c1 - c0) * ramp;
        EXPECT_NEAR(r.colour().r, exact, kTolerance * exact) << x;
    }
}

TEST(ReferenceIntegrator, T7StepSplitAtTheKink) {
    const double sigma = 4, s0 = 0.3721;
    ReferenceIntegrator r;
    const auto f = [&](double t) { return RadiantPoint{t < s0 ? 0 : sigma, glm::dvec3(1)}; };
    r.add(0, s0, f);
    r.add(s0, 1, f);
    EXPECT_NEAR(r.alpha(), -std::expm1(-sigma * (1 - s0)), kTolerance);
}

TEST(ReferenceIntegrator, T8LinearTimesLinear) {
    for (const double kappa : {0.01, 1.0, 10.0, 1000.0}) {
        const auto r = over(0, 1, [&](double u) { return RadiantPoint{kappa * u, glm::dvec3(u)}; });
        const double exact =
            std::sqrt(std::numbers::pi / (2 * kappa)) * std::erf(std::sqrt(kappa / 2)) - std::exp(-kappa / 2);
        EXPECT_NEAR(r.colour().b, exact, kTolerance) << kappa;
    }
}

TEST(ReferenceIntegrator, CuttingALineChangesNothing) {
    const auto f = [](double t) {
        return RadiantPoint{2 + std::sin(9 * t), glm::dvec3(0.5 + 0.5 * std::cos(5 * t))};
    };
    const auto whole = over(0, 3, f), cut = over(0, 3, f, 1000);
    EXPECT_NEAR(whole.alpha(), cut.alpha(), kTolerance);
    EXPECT_NEAR(whole.colour().r, cut.colour().r, kTolerance);
}

TEST(ReferenceIntegrator, StopsWhenNothingBehindCanShow) {
    int calls = 0;
    ReferenceIntegrator r;
    r.add(0, 1, [&](double) { return ++calls, RadiantPoint{1e5, glm::dvec3(1)}; });
    const int before = calls;
    r.add(1, 1e9, [&](double) { return ++calls, RadiantPoint{1e5, glm::dvec3(1)}; });
    EXPECT_TRUE(r.opaque());
    EXPECT_EQ(calls, before);
}

} // namespace
} // namespace tessera

// render/verify/distributions.cpp: see distributions.h.
#include "render/verify/distributions.h"

#include "core/base/error.h"

#include <cmath>

namespace tessera {
namespace {

/// The continued fraction of DLMF 8.17.22, by Lentz's method with Thompson and Barnett's guard against zeros.
double betaFraction(double a, double b, double x) {
    constexpr double kTiny = 1e-300;
    const auto away = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
    double c = 1, d = 1 / away(1 - (a + b) * x / (a + 1)), value = d;
    for (int m = 1; m < 10000; ++m) {
        const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        d = 1 / away(1 + even * d);
        c = away(1 + even / c);
        value *= d * c;
        const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        d = 1 / away(1 + odd * d);
        c = away(1 + odd / c);
        value *= d * c;
        if (std::abs(d * c - 1) < 1e-15)
            break;
    }
    return value;
}

/// P(T <= t), t at least 0.
double studentAtMost(double t, double degreesOfFreedom) {
    return 1 - 0.5 * incompleteBeta(degreesOfFreedom / 2, 0.5, degreesOfFreedom / (degreesOfFreedom + t * t));
}

} // namespace

double incompleteBeta(double a, double b, double x) {
    TESSERA_CHECK(a > 0 && b > 0);
    if (x <= 0)
        return 0;
    if (x >= 1)
        return 1;
    const double front =
        std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
    if (x < (a + 1) / (a + b + 2)) // where the fraction converges fast
        return front * betaFraction(a, b, x) / a;
    return 1 - front * betaFraction(b, a, 1 - x) / b;
}

double binomialAtMost(int k, int n, double chance) {
    if (k < 0)
        return 0;
    if (k >= n)
        return 1;
    return 1 - incompleteBeta(k + 1.0, static_cast<double>(n - k), chance);
}

double studentQuantile(double chance, double degreesOfFreedom) {
    TESSERA_CHECK(chance >= 0.5 && chance < 1 && degreesOfFreedom >= 1);
    double low = 0, high = 1;
    while (studentAtMost(high, degreesOfFreedom) < chance)
        high *= 2;
    for (int i = 0; i < 200 && high - low > 1e-13 * high; ++i) {
        const double middle = 0.5 * (low + high);
        (studentAtMost(middle, degreesOfFreedom) < chance ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

} // namespace tessera

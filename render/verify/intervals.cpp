// render/verify/intervals.cpp: see intervals.h.
#include "render/verify/intervals.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

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

std::optional<int> rankAbove(int n, double share, double chance) {
    std::optional<int> rank;
    for (int r = n; r >= 1 && 1 - std::pow(share, n) >= chance; --r) {
        if (binomialAtMost(r - 1, n, share) < chance)
            break;
        rank = r;
    }
    return rank;
}

std::optional<int> rankBelow(int n, double share, double chance) {
    for (int r = n; r >= 1; --r)
        if (binomialAtMost(r - 1, n, share) <= 1 - chance)
            return r;
    return std::nullopt;
}

std::optional<QuantileRanks> ranksAround(int n, double share, double chance) {
    // The largest value is the last possible rank; with a margin for rounding.
    const double above = std::max((1 - chance) / 2, std::pow(share, n) * (1 + 1e-9));
    const double below = 1 - chance - above;
    if (below <= 0)
        return std::nullopt;
    const std::optional<int> low = rankBelow(n, share, 1 - below), high = rankAbove(n, share, 1 - above);
    if (!low || !high)
        return std::nullopt;
    return QuantileRanks{*low, *high};
}

double ClusterSums::variance() const {
    double v = 0;
    for (std::size_t i = 0; i + 1 < sums_.size(); i += 2)
        v += (sums_[i] - sums_[i + 1]) * (sums_[i] - sums_[i + 1]);
    return v;
}

double ClusterSums::thirdMoment() const {
    double mean = 0, cubes = 0;
    for (const double s : sums_)
        mean += s / static_cast<double>(sums_.size());
    for (const double s : sums_)
        cubes += (s - mean) * (s - mean) * (s - mean);
    return cubes;
}

Interval clusterInterval(double estimate, const ClusterSums& sums, double worst) {
    const double t = studentQuantile(0.975, std::max(1, sums.strata()));
    const double error = std::sqrt(sums.variance());
    double low = -t, high = t;
    if (error > 0) {
        // Hall's T + g T^2 / 3 + g^2 T^3 / 27 + g / 6, g the skewness, solved for T.
        const double skewness = sums.thirdMoment() / (error * error * error);
        const auto halls = [&](double x) {
            return 3 / skewness * (std::cbrt(1 + skewness * (x - skewness / 6)) - 1);
        };
        if (std::abs(skewness) > 1e-6) {
            low = std::min(low, -halls(t));
            high = std::max(high, -halls(-t));
        }
    }
    return {estimate + low * error, estimate + high * error + worst};
}

} // namespace tessera

// render/verify/distributions.h: shares and quantiles of the binomial and Student's t
// distributions, for intervals.
#pragma once

namespace tessera {

/// Regularised incomplete beta function I_x(a, b), a and b above 0: by its continued fraction (NIST DLMF
/// 8.17.22), to about 1e-12.
double incompleteBeta(double a, double b, double x);

/// P(B <= k) for B successes of n trials, each with the given chance: 1 - I_chance(k + 1, n - k)
/// (DLMF 8.17.5).
double binomialAtMost(int k, int n, double chance);

/// The quantile t of Student's distribution for a probability of at least 0.5.
/// @param degreesOfFreedom  at least 1
double studentQuantile(double chance, double degreesOfFreedom);

} // namespace tessera

// render/verify/intervals.h: intervals of confidence: for quantiles of any distribution, and for means of
// clusters.
#pragma once

#include <optional>
#include <vector>

namespace tessera {

// Shares and quantiles of the binomial and Student's t distributions, for intervals.

/// Regularised incomplete beta function I_x(a, b), a and b above 0: by its continued fraction (NIST DLMF
/// 8.17.22), to about 1e-12.
double incompleteBeta(double a, double b, double x);

/// P(B <= k) for B successes of n trials, each with the given chance: 1 - I_chance(k + 1, n - k)
/// (DLMF 8.17.5).
double binomialAtMost(int k, int n, double chance);

/// The quantile t of Student's distribution for a probability of at least 0.5.
/// @param degreesOfFreedom  at least 1
double studentQuantile(double chance, double degreesOfFreedom);

// Distribution-free bounds of a population's quantile from a sample's ordered values. Ranks count the values
// in ascending order, from 1 to n.

/// The smallest rank whose value is at or above the population's quantile with at least the given probability
/// (Wilks 1941; David and Nagaraja, Order Statistics, 3rd ed. 2003, 7.1). It is the smallest r with P(B <= r
/// - 1) >= chance, B binomial of n trials with probability `share`. None if n is too small: the 99th
/// percentile at 95 % needs at least 299. It also holds for strata with different shares: sums of such trials
/// vary less than the binomial (Hoeffding 1956).
std::optional<int> rankAbove(int n, double share, double chance);
/// The largest rank whose value is at or below it with at least that probability: P(B <= r - 1) <= 1 -
/// chance.
std::optional<int> rankBelow(int n, double share, double chance);

struct QuantileRanks {
    int low = 0, high = 0;
};
/// The quantile lies between their values with at least the given probability. Either end takes half of the
/// rest, or the upper one more if n is too small for that (the 99th percentile at 95 %: below 368).
std::optional<QuantileRanks> ranksAround(int n, double share, double chance);

// A confidence interval for a mean estimated from clusters of pixels.

struct Interval {
    double low = 0, high = 0;
};

/// The contribution of each cluster to a linearised estimate's deviation (Cochran 1977, 6.4; Woodruff 1971).
/// For the mean of a domain, the sum of y over the sum of shown, it is the sum of (y - mean) / shown over the
/// cluster's shown pixels. Pixels of a cluster are correlated, so only clusters count as observations.
class ClusterSums {
  public:
    /// @param clusters  clusters 2h and 2h+1 are those of stratum h; even
    explicit ClusterSums(int clusters) : sums_(static_cast<std::size_t>(clusters), 0.0) {}
    void add(int cluster, double v) { sums_[static_cast<std::size_t>(cluster)] += v; }
    int strata() const { return static_cast<int>(sums_.size() / 2); }
    /// The variance of the estimate, by the difference of each stratum's two clusters (Cochran 1977, 5A.12,
    /// two draws with replacement a stratum).
    double variance() const;
    /// The variance of the estimate, ignoring strata.
    double thirdMoment() const;

  private:
    std::vector<double> sums_;
};

/// 95 %, by Student's t with as many degrees of freedom as strata; or by Hall's monotone cubic, which
/// corrects t for skewness (Hall 1992, J. R. Statist. Soc. B 54, 221), at either end if that is wider.
/// @param worst  contribution of one pixel like the worst in the sample. The upper end allows for it, because
///     errors of few pixels are often in no sample
Interval clusterInterval(double estimate, const ClusterSums& sums, double worst);

} // namespace tessera

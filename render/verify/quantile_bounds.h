// render/verify/quantile_bounds.h: distribution-free bounds of a population's quantile from a sample's
// ordered values. Ranks count the values in ascending order, from 1 to n.
#pragma once

#include <optional>

namespace tessera {

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

} // namespace tessera

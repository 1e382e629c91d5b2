// render/verify/quantile_bounds.h: bounds of a population's quantile from a sample's ordered values, whatever
// the distribution. Ranks count the values in ascending order, from 1 to n.
#pragma once

#include <optional>

namespace tessera {

/// The smallest rank whose value is at or above the population's quantile with at least the given chance: the
/// smallest r with P(B <= r - 1) >= chance, B binomial of n trials with chance `share` (Wilks 1941; David and
/// Nagaraja, Order Statistics, 3rd ed. 2003, 7.1). None where n is too small: for the 99th percentile and
/// 95 % it must be 299 at the least. It holds for strata whose shares differ, too: sums of such trials stray
/// less than the binomial does (Hoeffding 1956).
std::optional<int> rankAbove(int n, double share, double chance);
/// The largest rank whose value is at or below it with at least that chance: P(B <= r - 1) <= 1 - chance.
std::optional<int> rankBelow(int n, double share, double chance);

struct QuantileRanks {
    int low = 0, high = 0;
};
/// Between their values the quantile lies with at least the given chance. Either end takes half of what is
/// left, or the upper one more where n is too small for that (the 99th percentile and 95 %: below 368).
std::optional<QuantileRanks> ranksAround(int n, double share, double chance);

} // namespace tessera

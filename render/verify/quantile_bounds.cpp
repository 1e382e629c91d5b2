// render/verify/quantile_bounds.cpp: see quantile_bounds.h.
#include "render/verify/quantile_bounds.h"

#include "render/verify/distributions.h"

#include <algorithm>
#include <cmath>

namespace tessera {

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

} // namespace tessera

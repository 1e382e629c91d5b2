// render/verify/tail.h: the largest L*u*v* distances of a sample, and the share of the truth's noise in them.
#pragma once

#include "render/verify/pixel_pairs.h"

#include <algorithm>
#include <vector>

namespace tessera {

/// The quantile that is asked for.
constexpr double kTailShare = 0.99;
/// Where noise is more than this of the tail's squares they tell nothing of what it would be without.
constexpr double kMostNoise = 0.5;

class Tail {
  public:
    /// @param errors  of which at least one is shown
    explicit Tail(const std::vector<PixelError>& errors);

    /// Of the distribution that the values are a sample of: the 99th percentile that half of all samples are
    /// above, between two values (Hyndman and Fan 1996, type 8).
    double p99() const;
    /// Of the values as they are, ranked as compare() does (core/image/image_metrics.h).
    double p99OfAll() const;
    /// The value of a rank in a sample of as many values as this one is worth.
    double atRank(int rank, int worth) const;
    /// Shown pixels' values, ascending.
    const std::vector<double>& values() const { return once_; }

    /// Of squares of quantiles: the truth's noise, by quantiles with twice of it. Over the 97th to 99.7th
    /// percentiles, or the 90th to 99.7th where that is more: at the very end few pixels decide.
    double noiseShare() const { return std::max(noiseAtEnd_, noiseOfTail_); }
    /// What a quantile is to be multiplied by: by what the end alone says.
    double withoutNoise() const;
    /// What its lower end is to be multiplied by, at most that: 0 where kMostNoise is reached.
    double cautiously() const;

  private:
    std::vector<double> once_;
    double noiseAtEnd_ = 0, noiseOfTail_ = 0;
};

/// The variance of the share of shown pixels above a value, against that of as many independent ones; the
/// largest of the 90th to 99th percentiles, at least 1. As if clusters were of no strata.
double tailDesignEffect(const std::vector<PixelError>& errors, const Tail& tail, int clusters);

} // namespace tessera

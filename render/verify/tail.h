// render/verify/tail.h: the largest L*u*v* distances of a sample, and the share of the truth's noise in them.
#pragma once

#include "render/verify/pixel_pairs.h"

#include <algorithm>
#include <vector>

namespace tessera {

/// The requested quantile.
constexpr double kTailShare = 0.99;
/// Largest share of noise in the tail's squares that allows a correction.
constexpr double kMostNoise = 0.5;

class Tail {
  public:
    /// @param pixel errors, at least one of them shown
    explicit Tail(const std::vector<PixelError>& errors);

    /// A median-unbiased estimate of the 99th percentile, interpolated between two values (Hyndman and Fan
    /// 1996, type 8).
    double p99() const;
    /// The 99th percentile of the values themselves, ranked as in compare() (core/image/image_metrics.h).
    double p99OfAll() const;
    /// The value of a rank, scaled to the effective sample size.
    double atRank(int rank, int worth) const;
    /// Shown pixels' values, ascending.
    const std::vector<double>& values() const { return once_; }

    /// The share of the truth's noise in squares of quantiles, by quantiles with twice the noise. Over the
    /// 97th to 99.7th percentiles, or the 90th to 99.7th if that is more: the extreme end has few pixels.
    double noiseShare() const { return std::max(noiseAtEnd_, noiseOfTail_); }
    /// Correction factor of a quantile, by the extreme end alone.
    double withoutNoise() const;
    /// Correction factor of its lower end, at most that: 0 at kMostNoise.
    double cautiously() const;

  private:
    std::vector<double> once_;
    double noiseAtEnd_ = 0, noiseOfTail_ = 0;
};

/// The design effect: variance of the share of shown pixels above a value, relative to independent pixels;
/// the largest of the 90th to 99th percentiles, at least 1. Ignores strata.
double tailDesignEffect(const std::vector<PixelError>& errors, const Tail& tail, int clusters);

} // namespace tessera

// render/verify/measured_errors.h: the measured error of a picture, from a sample of pixels drawn again at
// full accuracy. Results are numbers with confidence intervals, or none: docs/measurements/measured-errors.md
// explains them.
#pragma once

#include "render/verify/pixel_sample.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace tessera {

// The largest L*u*v* distances of a sample, and the share of the truth's noise in them.

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

/// A number and its 95 % confidence interval over choices of pixels.
struct Estimate {
    double value = 0, low = 0, high = 0;
};

/// The reason if there is no 99th percentile.
enum class NotMeasured { no, tooFewPixels, truthTooNoisy };

/// Over visible pixels. None: not measured.
struct MeasuredErrors {
    int pixels = 0;                  // drawn again
    int shown = 0;                   // of these, with a visible truth
    int clusters = 0;                // clusters with such pixels, which are independent
    std::optional<Estimate> rms;     // linear light, all four components
    std::optional<Estimate> luvMean; // CIE L*u*v* distance
    std::optional<Estimate> luvP99;  // its 99th percentile
    NotMeasured whyNoP99 = NotMeasured::no;
    /// Upper bound of the 99th percentile at 95 %, for any distribution. The truth's noise is included and
    /// makes it larger, so it may be far above luvP99 if the truth has few samples.
    std::optional<double> luvP99Bound;
    double tailDesignEffect =
        1;                 // design effect: pixels per independent observation for clustered large errors
    double noiseShare = 0; // share of the truth's noise in the squares of large L*u*v* distances
};

/// Least number of independent visible clusters for the 99th percentile: Wilks 1941.
constexpr int kFewestForP99 = 299;
/// Least numbers of visible pixels and clusters for means: with fewer their intervals held too seldom.
constexpr int kFewestForMeans = 100, kFewestClusters = 48;

/// rms: the mean of squares without the truth's noise, its interval by clusters (intervals.h).
///
/// luvMean: noise lengthens distances, by an amount that depends on the distance without noise. They are
/// measured with the noise (m1) and with twice its variance (m2, half of the replicates), and extrapolated to
/// none (SIMEX: Cook and Stefanski 1994). The value is that of squares, 2 m1^2 - m2^2, exact if error and
/// noise have the same kind of distribution. The interval spans the results of two extremes. In one, noise
/// adds to a distance in proportion to its variance (2 m1 - m2). In the other it adds in proportion to its
/// standard deviation, as without any error ((sqrt(2) m1 - m2) / (sqrt(2) - 1)).
///
/// luvP99: order statistics (intervals.h; Woodruff 1952 for the principle) with an effective sample
/// size. That is shown pixels over the design effect of their tail (Korn and Graubard 1998), but not fewer
/// than clusters. Value and lower end are multiplied by the same extrapolation of the tail's squares; the
/// upper end is unchanged. There is no value if noise is more than half of these squares, and near that the
/// lower end is 0.
///
/// If all pixels were taken, only the truth's noise is random. Its share of the interval is the spread of
/// estimates when each pixel's replicates are resampled (bootstrap).
/// @param alphaAbove  as for pixelErrors()
/// @param boundChance  confidence of luvP99Bound
MeasuredErrors measuredErrors(const PixelPairs& pairs, float alphaAbove, double boundChance = 0.95);

/// The confidence of the bound in repeated attempts, each on other pixels, of which the first low enough
/// bound decides. All attempts together are then wrong in at most 5 %, however many there are. Each attempt
/// takes half of the rest: the first may be wrong in 2.5 %, which needs 368 clusters, the next in 1.25 %:
/// 437, then 506.
/// @param attempt  from 0 on
double chanceOfAttempt(int attempt);

} // namespace tessera

// render/verify/measured_errors.h: the measured error of a picture, from a sample of pixels that were drawn
// again as they should be. Results are numbers with intervals, or none: docs/measurements/measured-errors.md
// says what they mean.
#pragma once

#include "render/verify/pixel_pairs.h"

#include <optional>

namespace tessera {

/// A number and the interval that holds the truth in 95 of 100 choices of pixels.
struct Estimate {
    double value = 0, low = 0, high = 0;
};

/// Why there is no 99th percentile.
enum class NotMeasured { no, tooFewPixels, truthTooNoisy };

/// Over the pixels that show something. None: not measured.
struct MeasuredErrors {
    int pixels = 0;                  // drawn again
    int shown = 0;                   // of these, where the truth shows something
    int clusters = 0;                // that have such pixels: what is independent
    std::optional<Estimate> rms;     // linear light, all four components
    std::optional<Estimate> luvMean; // CIE L*u*v* distance
    std::optional<Estimate> luvP99;  // its 99th percentile
    NotMeasured whyNoP99 = NotMeasured::no;
    /// The 99th percentile is at most this, with 95 %, whatever the errors' distribution. The truth's noise
    /// is left in, which makes it larger, so it may be far above luvP99 where the truth has few samples.
    std::optional<double> luvP99Bound;
    double tailDesignEffect = 1; // how many pixels say as much as one, where large errors come in clusters
    double noiseShare = 0;       // of the squares of large L*u*v* distances: the truth's noise
};

/// Fewer independent clusters that show something tell nothing of the 99th percentile: Wilks 1941.
constexpr int kFewestForP99 = 299;
/// Nor of means, whose intervals held too seldom with fewer pixels that show something, or clusters that do.
constexpr int kFewestForMeans = 100, kFewestClusters = 48;

/// rms: the mean of squares without the truth's noise, its interval by clusters (cluster_interval.h).
///
/// luvMean: distances are not squares, noise makes them longer, by how much depends on what they are without
/// it. Measured with the noise (m1) and with twice its variance (m2, half of the replicates) they are
/// extrapolated to none (SIMEX: Cook and Stefanski 1994): 2 m1^2 - m2^2 of squares is the value, exact where
/// error and noise are alike in kind. The interval spans the results of two extremes. In one, noise adds to a
/// distance in proportion to its variance (2 m1 - m2). In the other it adds in proportion to its standard
/// deviation, as where nothing else is there ((sqrt(2) m1 - m2) / (sqrt(2) - 1)).
///
/// luvP99: order statistics (quantile_bounds.h; Woodruff 1952 for the principle), of as many values as the
/// sample is worth: shown pixels over the design effect of their tail (Korn and Graubard 1998), never fewer
/// than clusters. Value and lower end are multiplied by the same extrapolation of the tail's squares; the
/// upper end is left as it is. There is no number where noise is more than half of them, and no lower end but
/// 0 as that comes near.
///
/// Where all pixels were taken nothing is left to chance but the truth's noise: its share of the interval is
/// what estimates spread by when each pixel's replicates are drawn anew from themselves.
/// @param alphaAbove  as for pixelErrors()
/// @param boundChance  with which luvP99Bound holds
MeasuredErrors measuredErrors(const PixelPairs& pairs, float alphaAbove, double boundChance = 0.95);

/// The chance to ask of the bound where the first bound that is low enough certifies, on fresh pixels each
/// time. All attempts together are then wrong in at most 5 %, however many there are. Each attempt takes half
/// of what is left: it may be wrong in 2.5 %, which takes 368 clusters, the next in 1.25 %: 437, then 506.
/// @param attempt  from 0 on
double chanceOfAttempt(int attempt);

} // namespace tessera

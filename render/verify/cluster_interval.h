// render/verify/cluster_interval.h: an interval for a mean that was estimated from clusters of pixels.
#pragma once

#include <vector>

namespace tessera {

struct Interval {
    double low = 0, high = 0;
};

/// What each cluster adds to an estimate's deviation, once estimates are made linear: for the mean of a
/// domain (sum of y over sum of shown) the sum over its shown pixels of (y - mean) / shown (Cochran
/// 1977, 6.4; Woodruff 1971). Pixels of a cluster are alike, so only clusters count as observations.
class ClusterSums {
  public:
    /// @param clusters  clusters 2h and 2h+1 are those of stratum h; even
    explicit ClusterSums(int clusters) : sums_(static_cast<std::size_t>(clusters), 0.0) {}
    void add(int cluster, double v) { sums_[static_cast<std::size_t>(cluster)] += v; }
    int strata() const { return static_cast<int>(sums_.size() / 2); }
    /// Of the estimate: by the difference of each stratum's two (Cochran 1977, 5A.12, two draws with
    /// replacement a stratum).
    double variance() const;
    /// Of the estimate, as if clusters were of no strata.
    double thirdMoment() const;

  private:
    std::vector<double> sums_;
};

/// 95 %, by Student's t with as many degrees of freedom as strata; or by Hall's monotone cubic, which takes
/// the estimate's skewness out of t (Hall 1992, J. R. Statist. Soc. B 54, 221), at either end where
/// that is wider.
/// @param worst  what one pixel like the worst that was seen adds to the estimate: the upper end allows for
///     it, because errors that few pixels have are often in no sample at all
Interval clusterInterval(double estimate, const ClusterSums& sums, double worst);

} // namespace tessera

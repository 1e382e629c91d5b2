// render/verify/cluster_interval.h: a confidence interval for a mean estimated from clusters of pixels.
#pragma once

#include <vector>

namespace tessera {

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

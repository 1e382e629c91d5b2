// render/verify/cluster_interval.cpp: see cluster_interval.h.
#include "render/verify/cluster_interval.h"

#include "render/verify/distributions.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tessera {

double ClusterSums::variance() const {
    double v = 0;
    for (std::size_t i = 0; i + 1 < sums_.size(); i += 2)
        v += (sums_[i] - sums_[i + 1]) * (sums_[i] - sums_[i + 1]);
    return v;
}

double ClusterSums::thirdMoment() const {
    double mean = 0, cubes = 0;
    for (const double s : sums_)
        mean += s / static_cast<double>(sums_.size());
    for (const double s : sums_)
        cubes += (s - mean) * (s - mean) * (s - mean);
    return cubes;
}

Interval clusterInterval(double estimate, const ClusterSums& sums, double worst) {
    const double t = studentQuantile(0.975, std::max(1, sums.strata()));
    const double error = std::sqrt(sums.variance());
    double low = -t, high = t;
    if (error > 0) {
        // Hall's T + g T^2 / 3 + g^2 T^3 / 27 + g / 6, g the skewness, solved for T.
        const double skewness = sums.thirdMoment() / (error * error * error);
        const auto halls = [&](double x) {
            return 3 / skewness * (std::cbrt(1 + skewness * (x - skewness / 6)) - 1);
        };
        if (std::abs(skewness) > 1e-6) {
            low = std::min(low, -halls(t));
            high = std::max(high, -halls(-t));
        }
    }
    return {estimate + low * error, estimate + high * error + worst};
}

} // namespace tessera

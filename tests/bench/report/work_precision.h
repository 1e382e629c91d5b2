// tests/bench/report/work_precision.h: error against run time. It holds the settings that no other beats in
// both, and on them the time at an error and the error at a time. Also orders of convergence and the
// confidence of a ratio of times. Nothing is ever extrapolated.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace tessera::accuracy {

struct WorkPoint {
    double error = 0, ms = 0;
    std::size_t setting = 0; // the caller's number for it
};

/// The points that none of the others beats in both error and time: fastest first, errors falling.
std::vector<WorkPoint> paretoEnvelope(std::vector<WorkPoint> points);

/// Time at which an envelope reaches an error, between its points on the log-log line; where its fastest
/// point is better already, that point's time. None: not reached.
std::optional<double> timeAtError(const std::vector<WorkPoint>& envelope, double error);
/// Error at a time, likewise; where its slowest point is faster, that point's error. None: even its fastest
/// takes longer.
std::optional<double> errorAtTime(const std::vector<WorkPoint>& envelope, double ms);

/// The slope of log error against log step.
struct Order {
    double slope = 0;
    std::size_t points = 0; // that it was fitted to
};
/// Fitted to the coarsest points (step, error) of a run, as long as every halving reduces the error by at
/// least a fifth and the error is above `floor`. None if fewer than three are left.
/// @param points  any order; equal steps are not allowed
std::optional<Order> fittedOrder(std::vector<std::pair<double, double>> points, double floor);

/// How sure a ratio is: 95 % of what it comes to when blocks are drawn again with replacement.
struct RatioInterval {
    double low = 0, high = 0;
    /// A difference is only claimed where the interval excludes 1 and the ratio is off by more than 3 %.
    bool claimed(double ratio) const { return (low > 1 || high < 1) && (ratio > 1.03 || ratio < 1 / 1.03); }
};
/// @param a, b  least times of every block; the ratio is least a over least b
RatioInterval bootstrapRatio(const std::vector<double>& a, const std::vector<double>& b);

/// Of at least one value; linear between the two nearest ranks.
double quantile(std::vector<double> values, double share);

} // namespace tessera::accuracy

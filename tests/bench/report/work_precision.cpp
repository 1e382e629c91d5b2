// tests/bench/report/work_precision.cpp: see work_precision.h.
#include "tests/bench/report/work_precision.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace tessera::accuracy {
namespace {

constexpr double kLeastError = 1e-15; // stands for an error of zero on a logarithmic axis

double logError(double error) {
    return std::log(std::max(error, kLeastError));
}

/// The value at x on the line through two points of logarithms.
double between(double x0, double y0, double x1, double y1, double x) {
    return x1 == x0 ? y1 : y0 + (y1 - y0) * (x - x0) / (x1 - x0);
}

} // namespace

std::vector<WorkPoint> paretoEnvelope(std::vector<WorkPoint> points) {
    std::erase_if(points, [](const WorkPoint& p) { return !std::isfinite(p.error) || !(p.ms > 0); });
    std::sort(points.begin(), points.end(), [](const WorkPoint& a, const WorkPoint& b) {
        return std::pair(a.ms, a.error) < std::pair(b.ms, b.error);
    });
    std::vector<WorkPoint> envelope;
    for (const WorkPoint& p : points)
        if (envelope.empty() || p.error < envelope.back().error)
            envelope.push_back(p);
    return envelope;
}

std::optional<double> timeAtError(const std::vector<WorkPoint>& envelope, double error) {
    for (std::size_t i = 0; i < envelope.size(); ++i) {
        if (envelope[i].error > error)
            continue;
        if (i == 0)
            return envelope[0].ms;
        const WorkPoint &before = envelope[i - 1], &after = envelope[i];
        return std::exp(between(logError(before.error), std::log(before.ms), logError(after.error),
                                std::log(after.ms), logError(error)));
    }
    return std::nullopt;
}

std::optional<double> errorAtTime(const std::vector<WorkPoint>& envelope, double ms) {
    if (envelope.empty() || envelope.front().ms > ms)
        return std::nullopt;
    for (std::size_t i = 1; i < envelope.size(); ++i) {
        if (envelope[i].ms <= ms)
            continue;
        const WorkPoint &before = envelope[i - 1], &after = envelope[i];
        return std::exp(between(std::log(before.ms), logError(before.error), std::log(after.ms),
                                logError(after.error), std::log(ms)));
    }
    return envelope.back().error;
}

std::optional<Order> fittedOrder(std::vector<std::pair<double, double>> points, double floor) {
    std::sort(points.rbegin(), points.rend()); // coarsest first
    std::size_t used = 0;
    for (; used < points.size() && points[used].second > floor; ++used) {
        if (used == 0)
            continue;
        const double halvings = std::log2(points[used - 1].first / points[used].first);
        if (points[used].second > points[used - 1].second * std::pow(0.8, halvings))
            break;
    }
    if (used < 3)
        return std::nullopt;
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t i = 0; i < used; ++i) {
        const double x = std::log(points[i].first), y = logError(points[i].second);
        sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    const double n = static_cast<double>(used);
    return Order{(n * sxy - sx * sy) / (n * sxx - sx * sx), used};
}

RatioInterval bootstrapRatio(const std::vector<double>& a, const std::vector<double>& b) {
    TESSERA_CHECK(!a.empty() && !b.empty());
    constexpr int kDraws = 2000;
    std::mt19937 random(1); // the same interval for the same times
    const auto leastOfDrawn = [&random](const std::vector<double>& blocks) {
        std::uniform_int_distribution<std::size_t> pick(0, blocks.size() - 1);
        double least = blocks[pick(random)];
        for (std::size_t i = 1; i < blocks.size(); ++i)
            least = std::min(least, blocks[pick(random)]);
        return least;
    };
    std::vector<double> ratios;
    for (int i = 0; i < kDraws; ++i) {
        const double numerator = leastOfDrawn(a);
        ratios.push_back(numerator / leastOfDrawn(b));
    }
    return {quantile(ratios, 0.025), quantile(ratios, 0.975)};
}

double quantile(std::vector<double> values, double share) {
    TESSERA_CHECK(!values.empty());
    std::sort(values.begin(), values.end());
    const double at = share * static_cast<double>(values.size() - 1);
    const auto low = static_cast<std::size_t>(at);
    const std::size_t high = std::min(low + 1, values.size() - 1);
    return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

} // namespace tessera::accuracy

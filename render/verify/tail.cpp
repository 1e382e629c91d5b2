// render/verify/tail.cpp: see tail.h.
#include "render/verify/tail.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tessera {
namespace {

double quantile(const std::vector<double>& ascending, double share) {
    return ascending[static_cast<std::size_t>(share * static_cast<double>(ascending.size() - 1))];
}

/// The noise in squares of quantiles between two per mille: the increase when noise is doubled.
/// @param twice  each against one half of the replicates, so that all have as many values as once
double noiseOf(const std::vector<double>& once, const std::vector<std::vector<double>>& twice, int from,
               int to) {
    double a = 0, b = 0;
    for (int p = from; p <= to; ++p) {
        const double q = quantile(once, p / 1000.0);
        a += q * q;
        for (const std::vector<double>& half : twice)
            b += std::pow(quantile(half, p / 1000.0), 2) / static_cast<double>(twice.size());
    }
    return a > 0 ? std::clamp(b / a - 1, 0.0, 1.0) : 0;
}

} // namespace

Tail::Tail(const std::vector<PixelError>& errors) {
    std::vector<std::vector<double>> twice(errors.empty() ? 0 : errors.front().luvHalves.size());
    for (const PixelError& e : errors)
        if (e.shown) {
            once_.push_back(e.luv);
            for (std::size_t half = 0; half < twice.size(); ++half)
                twice[half].push_back(e.luvHalves[half]);
        }
    TESSERA_CHECK(!once_.empty());
    std::sort(once_.begin(), once_.end());
    for (std::vector<double>& half : twice)
        std::sort(half.begin(), half.end());
    noiseAtEnd_ = noiseOf(once_, twice, 970, 997);
    noiseOfTail_ = noiseOf(once_, twice, 900, 997);
}

double Tail::p99() const {
    const double place = (static_cast<double>(once_.size()) + 1.0 / 3) * kTailShare + 1.0 / 3 - 1;
    const double last = static_cast<double>(once_.size() - 1), inside = std::clamp(place, 0.0, last);
    const auto below = static_cast<std::size_t>(inside), above = std::min(below + 1, once_.size() - 1);
    return once_[below] + (once_[above] - once_[below]) * (inside - static_cast<double>(below));
}

double Tail::p99OfAll() const {
    return quantile(once_, kTailShare);
}

double Tail::atRank(int rank, int worth) const {
    TESSERA_CHECK(rank >= 1 && rank <= worth);
    const double place = std::ceil(static_cast<double>(rank) * static_cast<double>(once_.size()) / worth);
    return once_[std::min(static_cast<std::size_t>(place), once_.size()) - 1];
}

double Tail::withoutNoise() const {
    return std::sqrt(1 - noiseAtEnd_);
}

double Tail::cautiously() const {
    return std::sqrt(1 - noiseShare()) * std::clamp(2 - 2 * noiseShare() / kMostNoise, 0.0, 1.0);
}

double tailDesignEffect(const std::vector<PixelError>& errors, const Tail& tail, int clusters) {
    double largest = 1;
    const auto shown = static_cast<double>(tail.values().size());
    for (const double at : {0.9, 0.95, 0.97, 0.98, 0.99}) {
        const double value = quantile(tail.values(), at);
        const auto last = std::upper_bound(tail.values().begin(), tail.values().end(), value);
        const double share = static_cast<double>(tail.values().end() - last) / shown;
        if (share <= 0)
            continue;
        std::vector<double> sums(static_cast<std::size_t>(clusters), 0.0);
        for (const PixelError& e : errors)
            if (e.shown)
                sums[static_cast<std::size_t>(e.cluster)] += (e.luv > value ? 1 : 0) - share;
        double squares = 0; // their mean is 0
        for (const double s : sums)
            squares += s * s;
        squares *= static_cast<double>(clusters) / (clusters - 1.0);
        largest = std::max(largest, squares / (shown * share * (1 - share)));
    }
    return largest;
}

} // namespace tessera

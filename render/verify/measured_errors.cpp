// render/verify/measured_errors.cpp: see measured_errors.h.
#include "render/verify/measured_errors.h"

#include "core/base/error.h"
#include "render/verify/intervals.h"
#include "render/verify/pixel_sample.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

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

namespace {

constexpr int kRedraws = 100; // of replicates, where all pixels were taken
constexpr double kNormal975 = 1.959963984540054;

double root(double square) {
    return std::sqrt(std::max(0.0, square));
}

/// Means of the L*u*v* distance by method of noise correction.
struct Luv {
    double value, proportional, rooted; // measured_errors.h: of squares, of the variance, of its root
    Luv(double once, double twice)
        : value(root(2 * once * once - twice * twice)), proportional(2 * once - twice),
          rooted((std::numbers::sqrt2 * once - twice) / (std::numbers::sqrt2 - 1)) {}
};

/// Over the shown pixels.
struct Means {
    double shown = 0, square = 0, once = 0, twice = 0; // L*u*v*: with the noise, with twice its variance
    double worstSquare = 0, worstLuv = 0;
    explicit Means(const std::vector<PixelError>& errors) {
        for (const PixelError& e : errors) {
            if (!e.shown)
                continue;
            ++shown;
            square += e.square;
            once += e.luv;
            twice += e.luvNoisier;
            worstSquare = std::max(worstSquare, e.square);
            worstLuv = std::max(worstLuv, e.luv);
        }
        for (double* sum : {&square, &once, &twice})
            *sum /= std::max(1.0, shown);
    }
    Luv luv() const { return {once, twice}; }
};

/// Makes an interval include its value, with no end below 0.
Estimate estimateOf(double value, double low, double high) {
    value = std::max(0.0, value);
    return {value, std::clamp(low, 0.0, value), std::max(value, high)};
}

void measureMeans(MeasuredErrors& m, const std::vector<PixelError>& errors, int clusters) {
    const Means means(errors);
    const Luv luv = means.luv();
    ClusterSums squares(clusters), proportional(clusters), rooted(clusters);
    for (const PixelError& e : errors) {
        if (!e.shown)
            continue;
        squares.add(e.cluster, (e.square - means.square) / means.shown);
        const double once = (e.luv - means.once) / means.shown,
                     twice = (e.luvNoisier - means.twice) / means.shown;
        const Luv deviation(once, twice);
        proportional.add(e.cluster, deviation.proportional);
        rooted.add(e.cluster, deviation.rooted);
    }
    const Interval square = clusterInterval(means.square, squares, means.worstSquare / means.shown);
    m.rms = estimateOf(root(means.square), root(square.low), root(square.high));
    const double worst = means.worstLuv / means.shown;
    const Interval a = clusterInterval(luv.proportional, proportional, worst),
                   b = clusterInterval(luv.rooted, rooted, worst);
    m.luvMean = estimateOf(luv.value, std::min(a.low, b.low), std::max(a.high, b.high));
}

void measureTail(MeasuredErrors& m, const std::vector<PixelError>& errors, int clusters, double boundChance) {
    if (m.clusters < kFewestForP99) {
        m.whyNoP99 = NotMeasured::tooFewPixels;
        return;
    }
    const Tail tail(errors);
    m.tailDesignEffect = clusters < m.pixels ? tailDesignEffect(errors, tail, clusters) : 1;
    m.noiseShare = tail.noiseShare();
    const int worth = std::clamp(static_cast<int>(m.shown / m.tailDesignEffect), m.clusters, m.shown);
    // No other estimate: pixels of a cluster may be correlated, clusters are independent.
    if (const auto rank = rankAbove(m.clusters, kTailShare, boundChance))
        m.luvP99Bound = tail.atRank(*rank, m.clusters);
    const auto ranks = ranksAround(worth, kTailShare, 0.95);
    if (!ranks)
        m.whyNoP99 = NotMeasured::tooFewPixels;
    else if (m.noiseShare < kMostNoise)
        m.luvP99 =
            estimateOf(tail.withoutNoise() * tail.p99(), tail.cautiously() * tail.atRank(ranks->low, worth),
                       tail.atRank(ranks->high, worth));
    else
        m.whyNoP99 = NotMeasured::truthTooNoisy;
}

/// Standard deviations of what is estimated, by the truth's noise.
struct NoiseSpread {
    double square = 0, proportional = 0, rooted = 0, p99 = 0;
};

NoiseSpread spreadOfRedraws(const PixelPairs& pairs, float alphaAbove) {
    if (pairs.replicates < 2)
        return {};
    const auto each = static_cast<std::size_t>(pairs.replicates);
    // Correction of residuals, which are too small for a mean of few.
    const float widen = std::sqrt(static_cast<float>(each) / static_cast<float>(each - 1));
    RandomNumbers random(0);
    PixelPairs again = pairs;
    NoiseSpread sums, squares;
    for (int redraw = 0; redraw < kRedraws; ++redraw) {
        for (std::size_t i = 0; i < pairs.picture.size(); ++i) {
            const glm::vec4* mine = &pairs.truth[i * each];
            glm::vec4 mean(0);
            for (std::size_t r = 0; r < each; ++r)
                mean += mine[r] / static_cast<float>(each);
            for (std::size_t r = 0; r < each; ++r)
                again.truth[i * each + r] =
                    mean + widen * (mine[static_cast<std::size_t>(random.below(each))] - mean);
        }
        const std::vector<PixelError> errors = pixelErrors(again, alphaAbove);
        const Means means(errors);
        if (means.shown == 0)
            continue;
        const Luv luv = means.luv();
        const auto take = [](double v, double& sum, double& square) {
            sum += v / kRedraws;
            square += v * v / kRedraws;
        };
        take(means.square, sums.square, squares.square);
        take(luv.proportional, sums.proportional, squares.proportional);
        take(luv.rooted, sums.rooted, squares.rooted);
        take(Tail(errors).p99(), sums.p99, squares.p99);
    }
    return {root(squares.square - sums.square * sums.square),
            root(squares.proportional - sums.proportional * sums.proportional),
            root(squares.rooted - sums.rooted * sums.rooted), root(squares.p99 - sums.p99 * sums.p99)};
}

void measureAll(MeasuredErrors& m, const PixelPairs& pairs, float alphaAbove,
                const std::vector<PixelError>& errors) {
    NoiseSpread wide = spreadOfRedraws(pairs, alphaAbove);
    for (double* s : {&wide.square, &wide.proportional, &wide.rooted, &wide.p99})
        *s *= kNormal975;
    const Means means(errors);
    const Luv luv = means.luv();
    m.rms =
        estimateOf(root(means.square), root(means.square - wide.square), root(means.square + wide.square));
    m.luvMean =
        estimateOf(luv.value, std::min(luv.rooted - wide.rooted, luv.proportional - wide.proportional),
                   std::max(luv.rooted + wide.rooted, luv.proportional + wide.proportional));
    const Tail tail(errors);
    const double p99 = tail.p99OfAll();
    m.noiseShare = tail.noiseShare();
    m.luvP99Bound = p99 + wide.p99;
    if (m.noiseShare < kMostNoise)
        m.luvP99 =
            estimateOf(tail.withoutNoise() * p99, tail.cautiously() * (p99 - wide.p99), p99 + wide.p99);
    else
        m.whyNoP99 = NotMeasured::truthTooNoisy;
}

} // namespace

MeasuredErrors measuredErrors(const PixelPairs& pairs, float alphaAbove, double boundChance) {
    const std::vector<PixelError> errors = pixelErrors(pairs, alphaAbove);
    MeasuredErrors m;
    m.pixels = static_cast<int>(errors.size());
    int last = -1;
    for (const PixelError& e : errors)
        if (e.shown) {
            ++m.shown;
            m.clusters += e.cluster != last;
            last = e.cluster;
        }
    if (pairs.sample.all && m.shown > 0) {
        measureAll(m, pairs, alphaAbove, errors);
        return m;
    }
    if (m.shown >= kFewestForMeans && m.clusters >= kFewestClusters)
        measureMeans(m, errors, pairs.sample.clusters);
    measureTail(m, errors, pairs.sample.clusters, boundChance);
    return m;
}

double chanceOfAttempt(int attempt) {
    return 1 - std::ldexp(0.05, -(attempt + 1));
}

} // namespace tessera

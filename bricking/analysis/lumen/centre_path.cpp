// bricking/analysis/lumen/centre_path.cpp: see centre_path.h.
#include "bricking/analysis/lumen/centre_path.h"

#include "bricking/analysis/lumen/smooth_line.h"
#include "core/base/interrupt.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {
namespace {

constexpr int kRays = 24; // of a section
constexpr double kFartherThanMost =
    1.1; // rays count up to this many times the section's median, because of branches
constexpr int kRounds = 6;
constexpr double kSmooth = 0.7; // deviation of the Gaussian, of the lumen's radius
constexpr double kWideTurn =
    1.5; // radius of a turn, relative to the lumen's, from which on smoothing is full
constexpr double kLeastSmooth = 0.7; // of that, in the tightest turns
constexpr double kTightest = 0.5;    // radius of a turn, of the lumen's
constexpr double kBesideGapMm = 8;
constexpr double kLookMm = 0.25; // smallest spacings: closer together points follow no bend
constexpr double kMostRayMm = 100;
constexpr std::size_t kFarSeen = 40; // voxels of the chain

/// A line's points, each with its position on the chain and the allowed smoothing.
struct Stations {
    std::vector<glm::dvec3> mm;
    std::vector<double> chain;  // place on the chain
    std::vector<double> radius; // of the section, mm
};

class Centring {
  public:
    Centring(const LumenShape& shape, const std::vector<ChainPiece>& pieces, LumenValues& values,
             const LumenRule& rule, const CentringRules& rules)
        : shape_(shape), values_(values), rule_(rule), rules_(rules) {
        for (const ChainPiece& piece : pieces)
            for (const glm::dvec3& mm : piece.mm) {
                if (!chain_.empty() && glm::length(chain_.back() - mm) < 1e-9)
                    continue;
                chain_.push_back(mm);
                bridge_.push_back(piece.bridge);
            }
        widenBridges();
        if (chain_.size() == 1) { // a seed alone: a line needs two points
            chain_.push_back(chain_.front());
            bridge_.push_back(bridge_.front());
        }
    }

    CentredLine run() {
        begin();
        std::vector<glm::dvec3> middles;
        for (int round = 0; round < kRounds; ++round) {
            checkInterrupted();
            middles = sections();
            Stations next = stations_;
            next.mm = smoothed(middles, deviations());
            if (rules_.holdFirst)
                next.mm.front() = chain_.front();
            stations_ = std::move(next);
            pullInside();
            respace();
        }
        middles = sections();
        settle(middles);
        return result();
    }

  private:
    bool onBridge(double chain) const { return bridge_[static_cast<std::size_t>(std::lround(chain))]; }
    glm::dvec3 onChain(double place) const { return pointAt(chain_, place, true); }

    /// The end of a lumen at a gap is a dent in its wall: near it the line may leave the lumen.
    void widenBridges() {
        const std::vector<double> arcs = arcsOf(chain_);
        const std::vector<bool> bare = bridge_;
        for (std::size_t i = 0; i < bare.size(); ++i)
            for (std::size_t j = i; bare[i] && j < bare.size() && arcs[j] - arcs[i] < kBesideGapMm; ++j)
                bridge_[j] = true;
        for (std::size_t i = bare.size(); i-- > 0;)
            for (std::size_t j = i; bare[i] && arcs[i] - arcs[j] < kBesideGapMm; --j) {
                bridge_[j] = true;
                if (j == 0)
                    break;
            }
    }

    /// The chain, smoothed roughly and spaced evenly.
    void begin() {
        const std::size_t n = chain_.size();
        const std::size_t apart = std::max<std::size_t>(1, n / 400);
        std::vector<double> rough(n, 0), deviation(n, 0);
        parallelFor((n + apart - 1) / apart, 0, [&](std::size_t k) {
            rough[k * apart] = shape_.holds(chain_[k * apart]) ? shape_.roughRadiusMm(chain_[k * apart]) : 0;
        });
        const double stepMm =
            std::max(arcsOf(chain_).back() / static_cast<double>(std::max<std::size_t>(n - 1, 1)), 1e-6);
        double sum = 0;
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t known = i / apart * apart;
            deviation[i] = std::min(rough[known] / stepMm, static_cast<double>(n) / 4);
            sum += rough[known];
        }
        const double usual = sum / static_cast<double>(n);
        stepMm_ = std::clamp(0.25 * usual, 0.5 * shape_.smallestSpacingMm(), 1.0);
        const std::vector<glm::dvec3> soft = blurred(chain_, deviation);
        stations_.chain = evenPlaces(soft, stepMm_);
        stations_.mm.resize(stations_.chain.size());
        for (std::size_t i = 0; i < stations_.mm.size(); ++i)
            stations_.mm[i] = pointAt(soft, stations_.chain[i], true);
        stations_.radius.assign(stations_.mm.size(), usual);
        pullInside();
    }

    /// Moves points outside the lumen towards their position on the chain until they are inside.
    void pullInside() {
        for (std::size_t i = 0; i < stations_.mm.size(); ++i) {
            if (onBridge(stations_.chain[i]))
                continue;
            const glm::dvec3 home = onChain(stations_.chain[i]);
            for (int half = 0; half < 4 && !shape_.holds(stations_.mm[i]); ++half)
                stations_.mm[i] = half < 3 ? 0.5 * (stations_.mm[i] + home) : home;
        }
    }

    void respace() {
        const std::vector<double> places = evenPlaces(stations_.mm, stepMm_);
        Stations next;
        for (const double place : places) {
            const std::size_t i = std::min(static_cast<std::size_t>(place), stations_.mm.size() - 2);
            const double t = place - static_cast<double>(i);
            next.mm.push_back(pointAt(stations_.mm, place, true));
            next.chain.push_back(stations_.chain[i] + t * (stations_.chain[i + 1] - stations_.chain[i]));
            next.radius.push_back(stations_.radius[i] + t * (stations_.radius[i + 1] - stations_.radius[i]));
        }
        stations_ = std::move(next);
    }

    /// Deviation of the smoothing at every station, in stations: by the lumen's radius, less in turns that
    /// are hardly wider.
    std::vector<double> deviations() const {
        std::vector<double> deviation(stations_.mm.size());
        for (std::size_t i = 0; i < deviation.size(); ++i) {
            const double radius = stations_.radius[i];
            const double turn =
                std::clamp(turnMm(stations_.mm, i, turnReach(i)) / (kWideTurn * radius), kLeastSmooth, 1.0);
            deviation[i] =
                std::min(turn * kSmooth * radius / stepMm_, static_cast<double>(deviation.size()) / 4);
        }
        return blurredNumbers(deviation);
    }

    /// Radii change slowly along a lumen; those of single sections do not.
    std::vector<double> blurredNumbers(const std::vector<double>& numbers) const {
        std::vector<glm::dvec3> line;
        for (const double number : numbers)
            line.emplace_back(number, 0, 0);
        line = blurred(line, numbers);
        std::vector<double> out;
        for (const glm::dvec3& p : line)
            out.push_back(std::max(p.x, 0.0));
        return out;
    }

    /// The middle of every station's section; sets their radii.
    std::vector<glm::dvec3> sections() {
        const std::size_t n = stations_.mm.size();
        std::vector<glm::dvec3> middles = stations_.mm;
        parallelFor((n + 15) / 16, 0, [&](std::size_t block) {
            for (std::size_t i = 16 * block; i < std::min(n, 16 * block + 16); ++i)
                middles[i] = sectionMiddle(i);
        });
        return middles;
    }

    glm::dvec3 sectionMiddle(std::size_t i) {
        const std::vector<glm::dvec3>& mm = stations_.mm;
        if (onBridge(stations_.chain[i]) || !shape_.holds(mm[i]))
            return mm[i];
        const auto reach =
            static_cast<std::size_t>(std::max(1.0, std::round(0.5 * stations_.radius[i] / stepMm_)));
        glm::dvec3 along = mm[std::min(i + reach, mm.size() - 1)] - mm[i >= reach ? i - reach : 0];
        if (!(glm::length(along) > 0))
            return mm[i];
        along = glm::normalize(along);
        const glm::dvec3 beside = std::abs(along.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
        const glm::dvec3 u = glm::normalize(glm::cross(along, beside)), v = glm::cross(along, u);
        std::array<double, kRays> lengths;
        std::array<glm::dvec3, kRays> directions;
        for (std::size_t k = 0; k < kRays; ++k) {
            const double angle = 2 * 3.14159265358979323846 * static_cast<double>(k) / kRays;
            directions[k] = std::cos(angle) * u + std::sin(angle) * v;
            lengths[k] = shape_.rayMm(mm[i], directions[k], kMostRayMm);
        }
        std::array<double, kRays> sorted = lengths;
        std::nth_element(sorted.begin(), sorted.begin() + kRays / 2, sorted.end());
        const double median = sorted[kRays / 2];
        glm::dvec3 moved(0); // for a round section this is the offset of its centre
        double sum = 0;
        for (std::size_t k = 0; k < kRays; ++k) {
            const double length = std::min(lengths[k], kFartherThanMost * median);
            moved += (2.0 / kRays) * length * directions[k];
            sum += length / kRays;
        }
        stations_.radius[i] = sum;
        return mm[i] + moved;
    }

    bool inside(const std::vector<glm::dvec3>& mm, std::size_t i) {
        return onBridge(stations_.chain[i]) || onBridge(stations_.chain[i + 1]) ||
               shape_.staysInside(mm[i], mm[i + 1], values_, rule_);
    }

    /// The line of the centres, smoothed as far as the lumen allows.
    void settle(const std::vector<glm::dvec3>& middles) {
        const std::size_t n = middles.size();
        const std::vector<double> most = deviations();
        std::vector<double> share(n, 1);
        std::vector<glm::dvec3> line;
        for (int round = 0; round < 6; ++round) {
            checkInterrupted();
            std::vector<double> deviation(n);
            for (std::size_t i = 0; i < n; ++i)
                deviation[i] = share[i] * most[i];
            line = smoothed(middles, deviation);
            if (rules_.holdFirst)
                line.front() = chain_.front();
            for (std::size_t i = 0; i < n; ++i)
                if (share[i] < 0.1)
                    line[i] = onTautChain(stations_.chain[i]);
            std::vector<double> less = share;
            bool good = true;
            for (std::size_t i = 0; i + 1 < n; ++i)
                if (!inside(line, i)) {
                    good = false;
                    const auto reach = static_cast<std::size_t>(1 + most[i]);
                    for (std::size_t j = i >= reach ? i - reach : 0; j < std::min(n, i + reach + 2); ++j)
                        less[j] = std::min(less[j], 0.5 * share[i]);
                }
            if (good)
                break;
            share = less;
        }
        stations_.mm = line;
        relaxTurns();
    }

    /// The chain without its corners: straight from a point to the furthest visible one.
    glm::dvec3 onTautChain(double place) {
        if (taut_.empty()) {
            for (std::size_t i = 0; i + 1 < chain_.size();) {
                checkInterrupted();
                taut_.push_back(i);
                std::size_t next = i + 1;
                while (next + 1 < chain_.size() && next - i < kFarSeen && !bridge_[next + 1] &&
                       shape_.staysInside(chain_[i], chain_[next + 1], values_, rule_))
                    ++next;
                i = next;
            }
            taut_.push_back(chain_.size() - 1);
        }
        const auto after =
            std::upper_bound(taut_.begin() + 1, taut_.end() - 1, static_cast<std::size_t>(place));
        const auto a = static_cast<double>(*(after - 1)), b = static_cast<double>(*after);
        const double t = std::clamp((place - a) / (b - a), 0.0, 1.0);
        return chain_[*(after - 1)] + t * (chain_[*after] - chain_[*(after - 1)]);
    }

    /// Relaxes turns tighter than the bound, as far as the lumen allows.
    void relaxTurns() {
        const std::size_t n = stations_.mm.size();
        for (int round = 0; round < 100; ++round) {
            bool moved = false;
            std::vector<glm::dvec3> next = stations_.mm;
            for (std::size_t i = 1; i + 1 < n; ++i) {
                if (turnMm(stations_.mm, i, turnReach(i)) >= kTightest * stations_.radius[i])
                    continue;
                const glm::dvec3 between = 0.5 * (stations_.mm[i - 1] + stations_.mm[i + 1]);
                next[i] = 0.5 * (stations_.mm[i] + between);
                moved = true;
            }
            if (!moved)
                return;
            for (std::size_t i = 1; i + 1 < n; ++i) {
                const bool was = next[i] != stations_.mm[i];
                if (was && (!shape_.staysInside(next[i - 1], next[i], values_, rule_) ||
                            !shape_.staysInside(next[i], next[i + 1], values_, rule_)))
                    next[i] = stations_.mm[i];
            }
            stations_.mm = next;
        }
    }
    std::size_t turnReach(std::size_t i) const {
        return static_cast<std::size_t>(std::max(1.0, std::round(0.5 * stations_.radius[i] / stepMm_)));
    }

    CentredLine result() {
        CentredLine line;
        // points on the curve, or on the lines between points where the curve would leave the lumen; more
        // closely spaced if that does not help
        for (int finer = 0; finer < 8; ++finer) {
            line.mm =
                evenly(stations_.mm, rules_.spacingMm / (1 << finer / 2), finer % 2 == 1, line.spacingMm);
            bool good = stepsHold(line.mm, line.spacingMm);
            for (std::size_t i = 0; i + 1 < line.mm.size() && good; ++i)
                good = bridged(i, line) || shape_.staysInside(line.mm[i], line.mm[i + 1], values_, rule_);
            if (good)
                break;
        }
        if (!stepsHold(line.mm, line.spacingMm)) { // a kink stays one however close points lie
            EvenSteps even = evenSteps(stations_.mm, rules_.spacingMm, kLookMm * shape_.smallestSpacingMm());
            line.mm = std::move(even.mm);
            line.spacingMm = even.spacingMm;
        }
        for (std::size_t i = 0; i < line.mm.size(); ++i) {
            if (i % 64 == 0)
                checkInterrupted();
            line.radiusMm.push_back(shape_.wallMm(line.mm[i], values_, rule_));
        }
        line.leastTurnMm = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < stations_.mm.size(); ++i)
            line.leastTurnMm = std::min(line.leastTurnMm, turnMm(stations_.mm, i, turnReach(i)));
        return line;
    }
    bool bridged(std::size_t i, const CentredLine& line) const {
        const double place = static_cast<double>(i) / static_cast<double>(line.mm.size() - 1) *
                             static_cast<double>(stations_.chain.size() - 1);
        const auto at = std::min(static_cast<std::size_t>(place), stations_.chain.size() - 1);
        return onBridge(stations_.chain[at]) ||
               onBridge(stations_.chain[std::min(at + 1, stations_.chain.size() - 1)]);
    }

    const LumenShape& shape_;
    LumenValues& values_;
    const LumenRule rule_;
    const CentringRules rules_;
    std::vector<glm::dvec3> chain_;
    std::vector<bool> bridge_;
    std::vector<std::size_t> taut_; // points of the chain that are kept; made on demand
    Stations stations_;
    double stepMm_ = 1;
};

} // namespace

CentredLine centrePath(const LumenShape& shape, const std::vector<ChainPiece>& pieces, LumenValues& values,
                       const LumenRule& rule, const CentringRules& rules) {
    return Centring(shape, pieces, values, rule, rules).run();
}

} // namespace tessera

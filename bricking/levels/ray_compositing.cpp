// bricking/levels/ray_compositing.cpp: see ray_compositing.h.
#include "bricking/levels/ray_compositing.h"

#include "core/base/brick.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace tessera {

void gradedFactors(const GradientOpacity& perMm, std::span<const std::uint8_t> codes, int level,
                   double valuePerCode, double segmentMm, std::span<double> factors) {
    // Differences over a pitch of the level to either side. Level 0 has samples of every second voxel, so a
    // difference spans two of them.
    constexpr std::array<int, kLevelCount> kReach = {0, 1, 2, 2, 4, 4}; // segments
    const double allAxes = std::sqrt(3.0);
    const auto between = [&](std::size_t a, std::size_t b) {
        const int change = std::abs(int{codes[a]} - int{codes[b]});
        return perMm.factor(allAxes * change * valuePerCode / (static_cast<double>(b - a) * segmentMm));
    };
    const std::size_t last = codes.size() - 1,
                      reach = static_cast<std::size_t>(kReach[static_cast<std::size_t>(level)]);
    for (std::size_t i = 0; i <= last; ++i) {
        if (reach > 0) {
            factors[i] = between(i - std::min(i, reach), std::min(i + reach, last));
            continue;
        }
        const double before = i > 0 ? between(i - 1, i) : between(0, 1);
        factors[i] = 0.5 * (before + (i < last ? between(i, i + 1) : before));
    }
}

FunctionSums::FunctionSums(const TransferTable& table) : table_(table) {
    upTo_.reserve(table.entries.size());
    upTo_.emplace_back(0);
    for (std::size_t i = 1; i < table.entries.size(); ++i)
        upTo_.push_back(upTo_.back() + 0.5 * (entry(i - 1) + entry(i)));
}

glm::dvec4 FunctionSums::at(double place) const {
    const double inside = std::clamp(place, 0.0, lastPlace());
    const std::size_t left = std::min(static_cast<std::size_t>(inside), upTo_.size() - 2);
    return glm::mix(entry(left), entry(left + 1), inside - static_cast<double>(left));
}

glm::dvec4 FunctionSums::upTo(double place) const {
    const double inside = std::clamp(place, 0.0, lastPlace());
    const std::size_t left = std::min(static_cast<std::size_t>(inside), upTo_.size() - 2);
    const double f = inside - static_cast<double>(left);
    return upTo_[left] + f * glm::mix(entry(left), entry(left + 1), 0.5 * f) +
           (place - inside) * entry(place < 0 ? 0 : upTo_.size() - 1);
}

double narrowness(const FunctionSums& sums, double width) {
    if (!(width > 0))
        return 0;
    double moved = 0, all = 0;
    const auto add = [&](double place, double share) {
        const double here = sums.at(place).a;
        const double around = (sums.upTo(place + 0.5 * width).a - sums.upTo(place - 0.5 * width).a) / width;
        moved += share * std::abs(here - around);
        all += share * here;
    };
    const auto entries = static_cast<int>(sums.lastPlace());
    for (int i = 0; i < entries; ++i)
        add(i + 0.5, 1);
    // The function continues beyond the table: a step is not narrow, whatever part of it the table covers.
    constexpr int kBeyond = 256;
    const double reach = 4 * width;
    for (int i = 0; i < kBeyond; ++i) {
        const double beyond = reach * (i + 0.5) / kBeyond;
        add(-beyond, reach / kBeyond);
        add(sums.lastPlace() + beyond, reach / kBeyond);
    }
    return all > 0 ? moved / all : 0;
}

bool isNarrow(const FunctionSums& sums, const TransferTable& table, const VolumeInfo& info,
              std::span<const float> ranges) {
    constexpr double kShareOfRange = 1.0 / 64, kNarrow = 0.25;
    if (ranges.empty())
        return false;
    double sum = 0;
    for (const float range : ranges)
        sum += static_cast<double>(range);
    const double stored = sum / static_cast<double>(ranges.size());
    const double perStored = std::abs(info.rescaleSlope) * static_cast<double>(table.entriesPerValue);
    return narrowness(sums, kShareOfRange * stored * perStored) > kNarrow;
}

NarrowCompositor::NarrowCompositor(const FunctionSums& sums, const TransferTable& table,
                                   const VolumeInfo& info)
    : sums_(sums), perStored_(info.rescaleSlope * static_cast<double>(table.entriesPerValue)),
      atZero_((info.rescaleIntercept - static_cast<double>(table.firstValue)) *
              static_cast<double>(table.entriesPerValue)) {}

void NarrowCompositor::setPart(const BrickRayPart& part) {
    const double lo = static_cast<double>(part.lo), range = static_cast<double>(part.hi) - lo;
    for (int i = 0; i < kPlaces; ++i) {
        const auto at = static_cast<std::size_t>(i);
        places_[at] = perStored_ * (lo + range * i / (kPlaces - 1)) + atZero_;
        upTo_[at] = sums_.upTo(places_[at]);
    }
}

glm::dvec4 NarrowCompositor::mean(int from, int to) const {
    if (from == to) { // one code: all values that it represents
        from = std::max(from - 1, 0);
        to = std::min(to + 1, kPlaces - 1);
    }
    const auto a = static_cast<std::size_t>(from), b = static_cast<std::size_t>(to);
    const double passed = places_[b] - places_[a];
    return passed == 0 ? sums_.at(places_[a]) : (upTo_[b] - upTo_[a]) / passed;
}

glm::dvec4 NarrowCompositor::composite(std::span<const std::uint8_t> codes, double segmentMm,
                                       std::span<const double> factors) const {
    glm::dvec3 colour(0);
    double through = 1;
    for (std::size_t i = 0; i < codes.size(); ++i) {
        // From halfway before to the middle, and on to halfway behind.
        const int here = 2 * codes[i];
        const int before = i > 0 ? codes[i - 1] + codes[i] : here;
        const int behind = i + 1 < codes.size() ? codes[i] + codes[i + 1] : here;
        const glm::dvec4 both = 0.5 * (mean(before, here) + mean(here, behind));
        if (!(both.a > 0))
            continue;
        const double alpha = -std::expm1(-both.a * (factors.empty() ? 1 : factors[i]) * segmentMm);
        colour += through * alpha / both.a * glm::dvec3(both);
        through *= 1 - alpha;
    }
    return {colour, through};
}

} // namespace tessera

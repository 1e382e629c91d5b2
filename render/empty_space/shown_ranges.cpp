// render/empty_space/shown_ranges.cpp: see shown_ranges.h.
#include "render/empty_space/shown_ranges.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostRanges = 256; // functions that users edit have few
constexpr double kReach = 3;             // entries: emptyOver() reads those less than two beyond its range

} // namespace

ShownRanges::ShownRanges(const TransferTable& table)
    : firstValue_(static_cast<double>(table.firstValue)),
      entriesPerValue_(static_cast<double>(table.entriesPerValue)), entries_(table.entries.size()) {
    const auto valueAt = [&](double entry) { return firstValue_ + entry / entriesPerValue_; };
    for (std::size_t i = 0; i < entries_ && !tooMany_; ++i) {
        if (!table.shows(i))
            continue;
        std::size_t end = i;
        while (end < entries_ && table.shows(end))
            ++end;
        shown_.push_back({i == 0 ? -kInfinity : valueAt(static_cast<double>(i) - 0.5),
                          end == entries_ ? kInfinity : valueAt(static_cast<double>(end) - 0.5)});
        tooMany_ = shown_.size() > kMostRanges;
        i = end;
    }
}

bool ShownRanges::shows(double value) const {
    return std::any_of(shown_.begin(), shown_.end(),
                       [&](const ValueRange& r) { return value > r.lowest && value < r.highest; });
}

std::vector<double> ShownRanges::ends() const {
    std::vector<double> ends;
    for (const ValueRange& r : shown_)
        for (const double end : {r.lowest, r.highest})
            if (std::isfinite(end))
                ends.push_back(end);
    return ends;
}

std::vector<ValueRange> ShownRanges::differences(const ShownRanges& other) const {
    if (tooMany_ || other.tooMany_ || entries_ == 0 || other.entries_ == 0)
        return {{-kInfinity, kInfinity}};
    std::vector<double> ends = this->ends();
    const std::vector<double> others = other.ends();
    ends.insert(ends.end(), others.begin(), others.end());
    std::sort(ends.begin(), ends.end());
    const double reach = kReach / std::min(entriesPerValue_, other.entriesPerValue_);
    std::vector<ValueRange> ranges;
    // Tables of different size round ranges differently: then also around every end of a visible range of
    // either.
    if (entries_ != other.entries_ || firstValue_ != other.firstValue_ ||
        entriesPerValue_ != other.entriesPerValue_)
        for (const double end : ends)
            ranges.push_back({end - reach, end + reach});
    for (std::size_t i = 0; i <= ends.size(); ++i) { // between one end and the next
        const double low = i == 0 ? -kInfinity : ends[i - 1], high = i == ends.size() ? kInfinity : ends[i];
        const double within = std::isfinite(low) ? (std::isfinite(high) ? 0.5 * (low + high) : low + 1)
                                                 : (std::isfinite(high) ? high - 1 : 0);
        if (low < high && shows(within) != other.shows(within))
            ranges.push_back({low - reach, high + reach});
    }
    return ranges;
}

} // namespace tessera

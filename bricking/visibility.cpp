// bricking/visibility.cpp: see visibility.h.
#include "bricking/visibility.h"

#include "core/error.h"

#include <algorithm>

namespace tessera {

std::vector<float> visibilityFactors(std::span<const std::uint32_t> counts, std::uint32_t countPerPixel,
                                     const ViewWeights& weights, const Selection& selection,
                                     Visibility last) {
    TESSERA_CHECK(counts.size() == weights.area.size() && counts.size() == selection.levels.size());
    TESSERA_CHECK(last.empty() || last.size() == counts.size());
    TESSERA_CHECK(countPerPixel > 0);
    std::vector<float> factors(counts.size(), kHiddenVisibility);
    for (std::size_t brick = 0; brick < counts.size(); ++brick) {
        const double whole = static_cast<double>(countPerPixel) * static_cast<double>(weights.area[brick]);
        const double fraction = whole > 0 ? std::min(static_cast<double>(counts[brick]) / whole, 1.0) : 0.0;
        const float now = std::max(static_cast<float>(fraction), kHiddenVisibility);
        factors[brick] = now;
        if (last.empty())
            continue;
        const float before = last[brick];
        if (now <= 2 * before && 2 * now >= before)
            factors[brick] = before;
        else if (now < before && selection.levels[brick] < kLevelCount - 1)
            factors[brick] = std::max(now, before / 2);
    }
    return factors;
}

} // namespace tessera

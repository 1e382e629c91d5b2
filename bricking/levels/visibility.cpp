// bricking/levels/visibility.cpp: see visibility.h.
#include "bricking/levels/visibility.h"

#include "core/base/error.h"

#include <algorithm>

namespace tessera {

std::vector<float> visibilityFactors(std::span<const SeenBrick> seen, const Selection& selection,
                                     std::span<const float> last) {
    TESSERA_CHECK(seen.size() == selection.levels.size());
    TESSERA_CHECK(last.empty() || last.size() == seen.size());
    std::vector<float> factors(seen.size());
    for (std::size_t brick = 0; brick < seen.size(); ++brick) {
        const SeenBrick& s = seen[brick];
        const double most = static_cast<double>(s.rays) * SeenBrick::kLightOfRay;
        const double light = s.rays == 0 ? 1.0 : std::min(s.light / most, 1.0);
        const float now = std::max(static_cast<float>(light), kHiddenVisibility);
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

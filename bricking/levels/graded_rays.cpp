// bricking/levels/graded_rays.cpp: see graded_rays.h.
#include "bricking/levels/graded_rays.h"

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

} // namespace tessera

// render/backends/gpu/pace.h: the size of the ray caster's next dispatch, learnt from dispatches that ran.
#pragma once

#include <algorithm>
#include <cstddef>

namespace tessera {

/// Learns the cost of an iteration here and gives the number of them that one dispatch may hold. A dispatch
/// of n rays cannot run more than n times its iteration limit, however dense its tile turns out. Its time is
/// not bounded, because its iterations may cost more than those before.
class Pace {
  public:
    std::size_t iterationsPerDispatch(double targetMs) const {
        return static_cast<std::size_t>(std::clamp(targetMs / msPerIteration_, 16384.0, 4e9));
    }
    void observe(double ms, std::size_t iterations) {
        constexpr std::size_t kTelling = 4096; // below it the cost of the dispatch itself drowns the rest
        if (iterations < kTelling)
            return;
        msPerIteration_ = std::max(ms / static_cast<double>(iterations), msPerIteration_ * 0.7);
    }

  private:
    double msPerIteration_ = 1e-3; // a cautious start: a microsecond
};

} // namespace tessera

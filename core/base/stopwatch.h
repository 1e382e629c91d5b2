// core/base/stopwatch.h: elapsed time by the clock.
#pragma once

#include <chrono>

namespace tessera {

inline double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace tessera

// render/verify/random.h: random numbers, the same on every machine and with every compiler.
#pragma once

#include <cstdint>

namespace tessera {

/// SplitMix64 (Steele, Lea, Flood 2014): a counter, mixed. Streams of a seed are unrelated.
class RandomNumbers {
  public:
    explicit RandomNumbers(std::uint64_t seed, std::uint64_t stream = 0)
        : state_(mixed(mixed(seed) + 0x9E3779B97F4A7C15u * (stream + 1))) {}
    std::uint64_t next() { return mixed(state_ += 0x9E3779B97F4A7C15u); }
    /// From 0 to below 1.
    double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
    /// Uniform from 0 to count - 1: values of the incomplete last interval of 2^64 are rejected.
    std::uint64_t below(std::uint64_t count) {
        const std::uint64_t leftOver = (0 - count) % count;
        for (;;)
            if (const std::uint64_t drawn = next(); drawn >= leftOver)
                return drawn % count;
    }

  private:
    static std::uint64_t mixed(std::uint64_t v) {
        v = (v ^ (v >> 30)) * 0xBF58476D1CE4E5B9u;
        v = (v ^ (v >> 27)) * 0x94D049BB133111EBu;
        return v ^ (v >> 31);
    }
    std::uint64_t state_;
};

} // namespace tessera

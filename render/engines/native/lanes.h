// render/engines/native/lanes.h: numbers side by side, one a ray: F floats, I whole numbers of 32 bits, M
// conditions. Three sets of instructions, chosen by how the including file is compiled: AVX-512, AVX2, or
// whatever the compiler makes of its own vectors (SSE2, NEON). Every operation is the one of IEEE that the
// scalar text means, rounded once and in the same order, so that a lane gets the bits of the float mirror.
//
// For packet_*.cpp alone: all of it lies in a namespace of the target, so that no copy made for one processor
// can be linked into what runs on another (tests/program/symbols_test.cpp).
#pragma once

#include <cstdint>

#if defined(__AVX512F__) || defined(__AVX2__)
#include <immintrin.h>
#endif

#if TESSERA_SANITIZED
#define TESSERA_LANE static inline
#else
#define TESSERA_LANE static inline __attribute__((always_inline))
#endif

#if defined(__AVX512F__)
#include "render/engines/native/lanes_avx512.h"
#elif defined(__AVX2__)
#include "render/engines/native/lanes_avx2.h"
#else
#include "render/engines/native/lanes_portable.h"
#endif
#include "render/engines/native/lanes_twice.h"

namespace tessera::TESSERA_LANES {

TESSERA_LANE M operator>(F a, F b) {
    return b < a;
}
TESSERA_LANE M operator>=(F a, F b) {
    return b <= a;
}
TESSERA_LANE M operator>(I a, I b) {
    return b < a;
}
TESSERA_LANE M operator!=(I a, I b) {
    return ~(a == b);
}
TESSERA_LANE I operator~(I a) {
    return a ^ I(-1);
}
TESSERA_LANE int count(M m) {
    return __builtin_popcount(bits(m));
}
TESSERA_LANE M none() {
    return fromBits(0);
}
TESSERA_LANE M every() {
    return fromBits(static_cast<unsigned>((std::uint64_t{1} << kWidth) - 1u));
}
template <int N> TESSERA_LANE I shl(I a) {
    return shl(a, I(N));
}
template <int N> TESSERA_LANE I shr(I a) {
    return shr(a, I(N));
}
template <int N> TESSERA_LANE I sar(I a) {
    return sar(a, I(N));
}

constexpr int kColumns = kWidth == 32 ? 8 : 4; // of a packet's pixels

constexpr float kMostFloat = 3.402823466e38f;

/// Three of them: a place or a direction.
struct F3 {
    F x, y, z;
};
TESSERA_LANE F3 operator+(F3 a, F3 b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
TESSERA_LANE F3 operator-(F3 a, F3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
TESSERA_LANE F3 operator*(F a, F3 b) {
    return {a * b.x, a * b.y, a * b.z};
}
TESSERA_LANE F3 select(M m, F3 a, F3 b) {
    return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}

} // namespace tessera::TESSERA_LANES

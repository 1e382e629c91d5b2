// render/backends/native/lanes.h: numbers side by side, one a ray: F floats, I whole numbers of 32 bits, M
// conditions. The including file's compiler flags choose one of three instruction sets: AVX-512, AVX2, or the
// compiler's own vectors (SSE2, NEON). Every operation is the one of IEEE that the scalar text means, rounded
// once and in the same order. So a lane gets the bits of the float mirror.
//
// For packet_*.cpp alone: all of it lies in a namespace of the instruction set ("target"). No copy made for
// one processor can be linked into a program that runs on another (tests/program/symbols_test.cpp).
#pragma once

#include <cstdint>

#if defined(__AVX512F__) || defined(__AVX2__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

#if TESSERA_SANITIZED
#define TESSERA_LANE static inline
#else
#define TESSERA_LANE static inline __attribute__((always_inline))
#endif

#if defined(__AVX512F__)
#include "render/backends/native/lanes_avx512.h"
#elif defined(__AVX2__)
#include "render/backends/native/lanes_avx2.h"
#else
#include "render/backends/native/lanes_portable.h"
#endif

#include "render/backends/native/lanes_twice.h"

namespace tessera::TESSERA_LANES {

namespace single {
TESSERA_LANE bool any(M m) {
    return bits(m) != 0;
}
#include "render/backends/native/lanes_derived.h"
} // namespace single
#include "render/backends/native/lanes_derived.h"

constexpr int kColumns = kWidth == 32 ? 8 : 4; // of a packet's pixels
// Of the processor: its registers, and whether four rows of samples come by loads (lanes_avx2.h) or by
// gathers.
#if defined(__AVX512F__) || defined(__aarch64__)
constexpr int kRegisters = 32;
#else
constexpr int kRegisters = 16;
#endif
#if defined(__AVX2__) && !defined(__AVX512F__)
constexpr bool kLoadsRows = true;
#else
constexpr bool kLoadsRows = false;
#endif

constexpr float kMostFloat = 3.402823466e38f;

} // namespace tessera::TESSERA_LANES

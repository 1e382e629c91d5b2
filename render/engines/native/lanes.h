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

namespace tessera::TESSERA_LANES {

#if defined(__AVX512F__)

constexpr int kWidth = 16;
struct M {
    __mmask16 v;
};
struct F {
    __m512 v;
    F() = default;
    TESSERA_LANE F make(__m512 v) {
        F f;
        f.v = v;
        return f;
    }
    __attribute__((always_inline)) F(float x) : v(_mm512_set1_ps(x)) {}
};
struct I {
    __m512i v;
    I() = default;
    TESSERA_LANE I make(__m512i v) {
        I i;
        i.v = v;
        return i;
    }
    __attribute__((always_inline)) I(std::int32_t x) : v(_mm512_set1_epi32(x)) {}
};
TESSERA_LANE F load(const float* p) {
    return F::make(_mm512_loadu_ps(p));
}
TESSERA_LANE I load(const std::int32_t* p) {
    return I::make(_mm512_loadu_si512(p));
}
TESSERA_LANE void store(float* p, F a) {
    _mm512_storeu_ps(p, a.v);
}
TESSERA_LANE void store(std::int32_t* p, I a) {
    _mm512_storeu_si512(p, a.v);
}
TESSERA_LANE F operator+(F a, F b) {
    return F::make(_mm512_add_ps(a.v, b.v));
}
TESSERA_LANE F operator-(F a, F b) {
    return F::make(_mm512_sub_ps(a.v, b.v));
}
TESSERA_LANE F operator*(F a, F b) {
    return F::make(_mm512_mul_ps(a.v, b.v));
}
TESSERA_LANE F operator/(F a, F b) {
    return F::make(_mm512_div_ps(a.v, b.v));
}
TESSERA_LANE M operator<(F a, F b) {
    return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ)};
}
TESSERA_LANE M operator<=(F a, F b) {
    return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ)};
}
TESSERA_LANE M operator==(F a, F b) {
    return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ)};
}
TESSERA_LANE M operator<(I a, I b) {
    return {_mm512_cmplt_epi32_mask(a.v, b.v)};
}
TESSERA_LANE M operator==(I a, I b) {
    return {_mm512_cmpeq_epi32_mask(a.v, b.v)};
}
TESSERA_LANE I operator+(I a, I b) {
    return I::make(_mm512_add_epi32(a.v, b.v));
}
TESSERA_LANE I operator-(I a, I b) {
    return I::make(_mm512_sub_epi32(a.v, b.v));
}
TESSERA_LANE I operator*(I a, I b) {
    return I::make(_mm512_mullo_epi32(a.v, b.v));
}
TESSERA_LANE I operator&(I a, I b) {
    return I::make(_mm512_and_si512(a.v, b.v));
}
TESSERA_LANE I operator|(I a, I b) {
    return I::make(_mm512_or_si512(a.v, b.v));
}
TESSERA_LANE I operator^(I a, I b) {
    return I::make(_mm512_xor_si512(a.v, b.v));
}
/// Left; right with zeros; right with the sign.
TESSERA_LANE I shl(I a, I n) {
    return I::make(_mm512_sllv_epi32(a.v, n.v));
}
TESSERA_LANE I shr(I a, I n) {
    return I::make(_mm512_srlv_epi32(a.v, n.v));
}
TESSERA_LANE I sar(I a, I n) {
    return I::make(_mm512_srav_epi32(a.v, n.v));
}
TESSERA_LANE M operator&(M a, M b) {
    return {static_cast<__mmask16>(a.v & b.v)};
}
TESSERA_LANE M operator|(M a, M b) {
    return {static_cast<__mmask16>(a.v | b.v)};
}
TESSERA_LANE M operator~(M a) {
    return {static_cast<__mmask16>(~a.v)};
}
TESSERA_LANE unsigned bits(M a) {
    return a.v;
}
TESSERA_LANE M fromBits(unsigned bits) {
    return {static_cast<__mmask16>(bits)};
}
TESSERA_LANE F select(M m, F a, F b) {
    return F::make(_mm512_mask_blend_ps(m.v, b.v, a.v));
}
TESSERA_LANE I select(M m, I a, I b) {
    return I::make(_mm512_mask_blend_epi32(m.v, b.v, a.v));
}
TESSERA_LANE F sqrt(F a) {
    return F::make(_mm512_sqrt_ps(a.v));
}
TESSERA_LANE F floor(F a) {
    return F::make(_mm512_roundscale_ps(a.v, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC));
}
TESSERA_LANE F ceil(F a) {
    return F::make(_mm512_roundscale_ps(a.v, _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC));
}
TESSERA_LANE F abs(F a) {
    return F::make(_mm512_abs_ps(a.v));
}
/// As std::min and std::max: the first where the two do not compare.
TESSERA_LANE F min(F a, F b) {
    return F::make(_mm512_min_ps(b.v, a.v));
}
TESSERA_LANE F max(F a, F b) {
    return F::make(_mm512_max_ps(b.v, a.v));
}
TESSERA_LANE I min(I a, I b) {
    return I::make(_mm512_min_epi32(a.v, b.v));
}
TESSERA_LANE I max(I a, I b) {
    return I::make(_mm512_max_epi32(a.v, b.v));
}
TESSERA_LANE I truncated(F a) {
    return I::make(_mm512_cvttps_epi32(a.v));
}
TESSERA_LANE F number(I a) {
    return F::make(_mm512_cvtepi32_ps(a.v));
}
TESSERA_LANE F asFloat(I a) {
    return F::make(_mm512_castsi512_ps(a.v));
}
TESSERA_LANE I asInt(F a) {
    return I::make(_mm512_castps_si512(a.v));
}
/// 32 bits at base + Scale * index, of the lanes of m; 0 elsewhere.
template <int Scale> TESSERA_LANE I gather(const void* base, I index, M m) {
    return I::make(_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), m.v, index.v, base, Scale));
}
/// 64 bits: the lower and the upper word.
struct Pair {
    I low, high;
};
template <int Scale> TESSERA_LANE Pair gatherPair(const void* base, I index, M m) {
    const __m512i a = _mm512_mask_i32gather_epi64(_mm512_setzero_si512(), static_cast<__mmask8>(m.v),
                                                  _mm512_castsi512_si256(index.v), base, Scale);
    const __m512i b = _mm512_mask_i32gather_epi64(_mm512_setzero_si512(), static_cast<__mmask8>(m.v >> 8),
                                                  _mm512_extracti64x4_epi64(index.v, 1), base, Scale);
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    const __m512i odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    return {I::make(_mm512_permutex2var_epi32(a, even, b)), I::make(_mm512_permutex2var_epi32(a, odd, b))};
}

#elif defined(__AVX2__)

constexpr int kWidth = 8;
struct M {
    __m256 v;
};
struct F {
    __m256 v;
    F() = default;
    TESSERA_LANE F make(__m256 v) {
        F f;
        f.v = v;
        return f;
    }
    __attribute__((always_inline)) F(float x) : v(_mm256_set1_ps(x)) {}
};
struct I {
    __m256i v;
    I() = default;
    TESSERA_LANE I make(__m256i v) {
        I i;
        i.v = v;
        return i;
    }
    __attribute__((always_inline)) I(std::int32_t x) : v(_mm256_set1_epi32(x)) {}
};
TESSERA_LANE F load(const float* p) {
    return F::make(_mm256_loadu_ps(p));
}
TESSERA_LANE I load(const std::int32_t* p) {
    return I::make(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));
}
TESSERA_LANE void store(float* p, F a) {
    _mm256_storeu_ps(p, a.v);
}
TESSERA_LANE void store(std::int32_t* p, I a) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a.v);
}
TESSERA_LANE F operator+(F a, F b) {
    return F::make(_mm256_add_ps(a.v, b.v));
}
TESSERA_LANE F operator-(F a, F b) {
    return F::make(_mm256_sub_ps(a.v, b.v));
}
TESSERA_LANE F operator*(F a, F b) {
    return F::make(_mm256_mul_ps(a.v, b.v));
}
TESSERA_LANE F operator/(F a, F b) {
    return F::make(_mm256_div_ps(a.v, b.v));
}
TESSERA_LANE M operator<(F a, F b) {
    return {_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)};
}
TESSERA_LANE M operator<=(F a, F b) {
    return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)};
}
TESSERA_LANE M operator==(F a, F b) {
    return {_mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ)};
}
TESSERA_LANE M operator<(I a, I b) {
    return {_mm256_castsi256_ps(_mm256_cmpgt_epi32(b.v, a.v))};
}
TESSERA_LANE M operator==(I a, I b) {
    return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(a.v, b.v))};
}
TESSERA_LANE I operator+(I a, I b) {
    return I::make(_mm256_add_epi32(a.v, b.v));
}
TESSERA_LANE I operator-(I a, I b) {
    return I::make(_mm256_sub_epi32(a.v, b.v));
}
TESSERA_LANE I operator*(I a, I b) {
    return I::make(_mm256_mullo_epi32(a.v, b.v));
}
TESSERA_LANE I operator&(I a, I b) {
    return I::make(_mm256_and_si256(a.v, b.v));
}
TESSERA_LANE I operator|(I a, I b) {
    return I::make(_mm256_or_si256(a.v, b.v));
}
TESSERA_LANE I operator^(I a, I b) {
    return I::make(_mm256_xor_si256(a.v, b.v));
}
TESSERA_LANE I shl(I a, I n) {
    return I::make(_mm256_sllv_epi32(a.v, n.v));
}
TESSERA_LANE I shr(I a, I n) {
    return I::make(_mm256_srlv_epi32(a.v, n.v));
}
TESSERA_LANE I sar(I a, I n) {
    return I::make(_mm256_srav_epi32(a.v, n.v));
}
TESSERA_LANE M operator&(M a, M b) {
    return {_mm256_and_ps(a.v, b.v)};
}
TESSERA_LANE M operator|(M a, M b) {
    return {_mm256_or_ps(a.v, b.v)};
}
TESSERA_LANE M operator~(M a) {
    return {_mm256_xor_ps(a.v, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))};
}
TESSERA_LANE unsigned bits(M a) {
    return static_cast<unsigned>(_mm256_movemask_ps(a.v));
}
TESSERA_LANE M fromBits(unsigned bits) {
    const __m256i one = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i all = _mm256_set1_epi32(static_cast<int>(bits));
    return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(all, one), one))};
}
TESSERA_LANE F select(M m, F a, F b) {
    return F::make(_mm256_blendv_ps(b.v, a.v, m.v));
}
TESSERA_LANE I select(M m, I a, I b) {
    return I::make(
        _mm256_castps_si256(_mm256_blendv_ps(_mm256_castsi256_ps(b.v), _mm256_castsi256_ps(a.v), m.v)));
}
TESSERA_LANE F sqrt(F a) {
    return F::make(_mm256_sqrt_ps(a.v));
}
TESSERA_LANE F floor(F a) {
    return F::make(_mm256_floor_ps(a.v));
}
TESSERA_LANE F ceil(F a) {
    return F::make(_mm256_ceil_ps(a.v));
}
TESSERA_LANE F abs(F a) {
    return F::make(_mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v));
}
TESSERA_LANE F min(F a, F b) {
    return F::make(_mm256_min_ps(b.v, a.v));
}
TESSERA_LANE F max(F a, F b) {
    return F::make(_mm256_max_ps(b.v, a.v));
}
TESSERA_LANE I min(I a, I b) {
    return I::make(_mm256_min_epi32(a.v, b.v));
}
TESSERA_LANE I max(I a, I b) {
    return I::make(_mm256_max_epi32(a.v, b.v));
}
TESSERA_LANE I truncated(F a) {
    return I::make(_mm256_cvttps_epi32(a.v));
}
TESSERA_LANE F number(I a) {
    return F::make(_mm256_cvtepi32_ps(a.v));
}
TESSERA_LANE F asFloat(I a) {
    return F::make(_mm256_castsi256_ps(a.v));
}
TESSERA_LANE I asInt(F a) {
    return I::make(_mm256_castps_si256(a.v));
}
template <int Scale> TESSERA_LANE I gather(const void* base, I index, M m) {
    return I::make(_mm256_mask_i32gather_epi32(_mm256_setzero_si256(), static_cast<const int*>(base), index.v,
                                               _mm256_castps_si256(m.v), Scale));
}
struct Pair {
    I low, high;
};
template <int Scale> TESSERA_LANE Pair gatherPair(const void* base, I index, M m) {
    const __m256i mask = _mm256_castps_si256(m.v);
    const auto* words = static_cast<const long long*>(base);
    const __m256i a =
        _mm256_mask_i32gather_epi64(_mm256_setzero_si256(), words, _mm256_castsi256_si128(index.v),
                                    _mm256_cvtepi32_epi64(_mm256_castsi256_si128(mask)), Scale);
    const __m256i b =
        _mm256_mask_i32gather_epi64(_mm256_setzero_si256(), words, _mm256_extracti128_si256(index.v, 1),
                                    _mm256_cvtepi32_epi64(_mm256_extracti128_si256(mask, 1)), Scale);
    const __m256 x = _mm256_castsi256_ps(a), y = _mm256_castsi256_ps(b);
    const __m256 low = _mm256_shuffle_ps(x, y, 0x88), high = _mm256_shuffle_ps(x, y, 0xdd);
    return {I::make(_mm256_permute4x64_epi64(_mm256_castps_si256(low), 0xd8)),
            I::make(_mm256_permute4x64_epi64(_mm256_castps_si256(high), 0xd8))};
}

#else

constexpr int kWidth = 4;
typedef float Floats __attribute__((vector_size(16)));
typedef std::int32_t Ints __attribute__((vector_size(16)));
typedef std::uint32_t Words __attribute__((vector_size(16)));
struct M {
    Ints v;
};
struct F {
    Floats v;
    F() = default;
    TESSERA_LANE F make(Floats v) {
        F f;
        f.v = v;
        return f;
    }
    __attribute__((always_inline)) F(float x) : v(Floats{x, x, x, x}) {}
};
struct I { // wraps around, as the hardware does
    Words v;
    I() = default;
    TESSERA_LANE I make(Words v) {
        I i;
        i.v = v;
        return i;
    }
    __attribute__((always_inline)) I(std::int32_t x) : v(Words{} + static_cast<std::uint32_t>(x)) {}
};
TESSERA_LANE F load(const float* p) {
    F a;
    __builtin_memcpy(&a.v, p, sizeof a.v);
    return a;
}
TESSERA_LANE I load(const std::int32_t* p) {
    I a;
    __builtin_memcpy(&a.v, p, sizeof a.v);
    return a;
}
TESSERA_LANE void store(float* p, F a) {
    __builtin_memcpy(p, &a.v, sizeof a.v);
}
TESSERA_LANE void store(std::int32_t* p, I a) {
    __builtin_memcpy(p, &a.v, sizeof a.v);
}
TESSERA_LANE F operator+(F a, F b) {
    return F::make(a.v + b.v);
}
TESSERA_LANE F operator-(F a, F b) {
    return F::make(a.v - b.v);
}
TESSERA_LANE F operator*(F a, F b) {
    return F::make(a.v * b.v);
}
TESSERA_LANE F operator/(F a, F b) {
    return F::make(a.v / b.v);
}
TESSERA_LANE M operator<(F a, F b) {
    return {a.v < b.v};
}
TESSERA_LANE M operator<=(F a, F b) {
    return {a.v <= b.v};
}
TESSERA_LANE M operator==(F a, F b) {
    return {a.v == b.v};
}
TESSERA_LANE M operator<(I a, I b) {
    return {(Ints)a.v < (Ints)b.v};
}
TESSERA_LANE M operator==(I a, I b) {
    return {a.v == b.v};
}
TESSERA_LANE I operator+(I a, I b) {
    return I::make(a.v + b.v);
}
TESSERA_LANE I operator-(I a, I b) {
    return I::make(a.v - b.v);
}
TESSERA_LANE I operator*(I a, I b) {
    return I::make(a.v * b.v);
}
TESSERA_LANE I operator&(I a, I b) {
    return I::make(a.v & b.v);
}
TESSERA_LANE I operator|(I a, I b) {
    return I::make(a.v | b.v);
}
TESSERA_LANE I operator^(I a, I b) {
    return I::make(a.v ^ b.v);
}
TESSERA_LANE I shl(I a, I n) {
    return I::make(a.v << n.v);
}
TESSERA_LANE I shr(I a, I n) {
    return I::make(a.v >> n.v);
}
TESSERA_LANE I sar(I a, I n) {
    return I::make((Words)((Ints)a.v >> (Ints)n.v));
}
TESSERA_LANE M operator&(M a, M b) {
    return {a.v & b.v};
}
TESSERA_LANE M operator|(M a, M b) {
    return {a.v | b.v};
}
TESSERA_LANE M operator~(M a) {
    return {~a.v};
}
TESSERA_LANE unsigned bits(M a) {
    unsigned all = 0;
    for (unsigned k = 0; k < kWidth; ++k)
        all |= (a.v[k] != 0 ? 1u : 0u) << k;
    return all;
}
TESSERA_LANE M fromBits(unsigned bits) {
    M m;
    for (unsigned k = 0; k < kWidth; ++k)
        m.v[k] = (bits >> k & 1u) != 0 ? -1 : 0;
    return m;
}
TESSERA_LANE F select(M m, F a, F b) {
    return F::make((Floats)(((Ints)a.v & m.v) | ((Ints)b.v & ~m.v)));
}
TESSERA_LANE I select(M m, I a, I b) {
    return I::make((Words)(((Ints)a.v & m.v) | ((Ints)b.v & ~m.v)));
}
TESSERA_LANE F sqrt(F a) {
    F r;
    for (int k = 0; k < kWidth; ++k)
        r.v[k] = __builtin_sqrtf(a.v[k]);
    return r;
}
TESSERA_LANE F abs(F a) {
    return F::make((Floats)((Ints)a.v & 0x7fffffff));
}
/// Whole numbers only where the float has them: from 2^23 on every float is whole.
TESSERA_LANE F floor(F a) {
    const M small = abs(a) < F(8388608.0f);
    const Floats whole =
        __builtin_convertvector(__builtin_convertvector(select(small, a, F(0.0f)).v, Ints), Floats);
    const F down = F::make(whole) - select(a < F::make(whole), F(1.0f), F(0.0f));
    return select(small, down, a);
}
TESSERA_LANE F ceil(F a) {
    return F(0.0f) - floor(F(0.0f) - a);
}
TESSERA_LANE F min(F a, F b) {
    return select(b < a, b, a);
}
TESSERA_LANE F max(F a, F b) {
    return select(a < b, b, a);
}
TESSERA_LANE I min(I a, I b) {
    return select(b < a, b, a);
}
TESSERA_LANE I max(I a, I b) {
    return select(a < b, b, a);
}
/// What is beyond 32 bits is any number, but one.
TESSERA_LANE I truncated(F a) {
    const F inside = select(abs(a) < F(2147483648.0f), a, F(0.0f));
    return I::make((Words) __builtin_convertvector(inside.v, Ints));
}
TESSERA_LANE F number(I a) {
    return F::make(__builtin_convertvector((Ints)a.v, Floats));
}
TESSERA_LANE F asFloat(I a) {
    return F::make((Floats)a.v);
}
TESSERA_LANE I asInt(F a) {
    return I::make((Words)a.v);
}
template <int Scale> TESSERA_LANE I gather(const void* base, I index, M m) {
    I r(0);
    for (int k = 0; k < kWidth; ++k)
        if (m.v[k] != 0) {
            std::uint32_t word;
            __builtin_memcpy(&word,
                             static_cast<const char*>(base) +
                                 std::int64_t{Scale} * static_cast<std::int32_t>(index.v[k]),
                             sizeof word);
            r.v[k] = word;
        }
    return r;
}
struct Pair {
    I low, high;
};
template <int Scale> TESSERA_LANE Pair gatherPair(const void* base, I index, M m) {
    Pair r{I(0), I(0)};
    for (int k = 0; k < kWidth; ++k)
        if (m.v[k] != 0) {
            std::uint32_t words[2];
            __builtin_memcpy(words,
                             static_cast<const char*>(base) +
                                 std::int64_t{Scale} * static_cast<std::int32_t>(index.v[k]),
                             sizeof words);
            r.low.v[k] = words[0];
            r.high.v[k] = words[1];
        }
    return r;
}

#endif

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
TESSERA_LANE bool any(M m) {
    return bits(m) != 0;
}
TESSERA_LANE int count(M m) {
    return __builtin_popcount(bits(m));
}
TESSERA_LANE M none() {
    return fromBits(0);
}
TESSERA_LANE M every() {
    return fromBits((1u << kWidth) - 1u);
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

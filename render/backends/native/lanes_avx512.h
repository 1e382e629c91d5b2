// render/backends/native/lanes_avx512.h: lanes of AVX-512, sixteen a register. For lanes.h alone.
#pragma once

namespace tessera::TESSERA_LANES::single {

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

/// Of every lane, whatever its condition. One load a lane and an exchange between lanes take a third of the
/// time of four gathers.
TESSERA_LANE void rows4(const float* words, I index, F (&out)[4]) {
    alignas(64) std::int32_t at[kWidth];
    store(at, index);
    const auto row = [&](int lane) { return _mm_loadu_ps(words + at[lane]); };
    const auto four = [&](int lane) { // a quarter of the register each
        __m512 r = _mm512_castps128_ps512(row(lane));
        r = _mm512_insertf32x4(r, row(lane + 4), 1);
        r = _mm512_insertf32x4(r, row(lane + 8), 2);
        return _mm512_insertf32x4(r, row(lane + 12), 3);
    };
    const __m512 a = four(0), b = four(1), c = four(2), d = four(3);
    const __m512 low = _mm512_unpacklo_ps(a, b), lowNext = _mm512_unpacklo_ps(c, d);
    const __m512 high = _mm512_unpackhi_ps(a, b), highNext = _mm512_unpackhi_ps(c, d);
    out[0] = F::make(_mm512_shuffle_ps(low, lowNext, 0x44));
    out[1] = F::make(_mm512_shuffle_ps(low, lowNext, 0xee));
    out[2] = F::make(_mm512_shuffle_ps(high, highNext, 0x44));
    out[3] = F::make(_mm512_shuffle_ps(high, highNext, 0xee));
}

/// The lanes of m go to the lowest ones; the others then have no meaning.
TESSERA_LANE F compress(F a, M m) {
    return F::make(_mm512_maskz_compress_ps(m.v, a.v));
}
TESSERA_LANE I compress(I a, M m) {
    return I::make(_mm512_maskz_compress_epi32(m.v, a.v));
}

} // namespace tessera::TESSERA_LANES::single

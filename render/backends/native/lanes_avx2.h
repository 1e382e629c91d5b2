// render/backends/native/lanes_avx2.h: lanes of AVX2, eight a register. For lanes.h alone.
#pragma once

namespace tessera::TESSERA_LANES::single {

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

TESSERA_LANE int wordAt(const void* from) {
    int word;
    __builtin_memcpy(&word, from, sizeof word);
    return word;
}
/// Of eight lanes four words each, lane by lane; by word.
TESSERA_LANE void acrossLanes(const __m128i (&lane)[8], I (&out)[4]) {
    const auto two = [&](int n) { // half of the register each
        return _mm256_castsi256_ps(_mm256_inserti128_si256(_mm256_castsi128_si256(lane[n]), lane[n + 4], 1));
    };
    const __m256 a = two(0), b = two(1), c = two(2), d = two(3);
    const __m256 low = _mm256_unpacklo_ps(a, b), lowNext = _mm256_unpacklo_ps(c, d);
    const __m256 high = _mm256_unpackhi_ps(a, b), highNext = _mm256_unpackhi_ps(c, d);
    const auto put = [](__m256 v) { return I::make(_mm256_castps_si256(v)); };
    out[0] = put(_mm256_shuffle_ps(low, lowNext, 0x44));
    out[1] = put(_mm256_shuffle_ps(low, lowNext, 0xee));
    out[2] = put(_mm256_shuffle_ps(high, highNext, 0x44));
    out[3] = put(_mm256_shuffle_ps(high, highNext, 0xee));
}
/// Words, or pairs of them, where samples of 16 bits lie: four from every lane's index on, each so many
/// samples beyond it. Those of lanes that are not of m have no meaning. By loads: gathers are slow on many
/// processors that have no wider registers.
template <typename Sample>
TESSERA_LANE void loadRows(const Sample* samples, I index, const std::int32_t (&of)[4], M m, I (&out)[4]) {
    static_assert(sizeof(Sample) == 2);
    alignas(32) std::int32_t at[kWidth];
    store(at, I::make(_mm256_and_si256(index.v, _mm256_castps_si256(m.v))));
    __m128i lanes[kWidth];
#pragma GCC unroll 8
    for (int lane = 0; lane < kWidth; ++lane) {
        const Sample* const from = samples + at[lane];
        const __m128i a = _mm_insert_epi32(_mm_loadu_si32(from + of[0]), wordAt(from + of[1]), 1);
        lanes[lane] = _mm_insert_epi32(_mm_insert_epi32(a, wordAt(from + of[2]), 2), wordAt(from + of[3]), 3);
    }
    acrossLanes(lanes, out);
}
template <typename Sample>
TESSERA_LANE void loadRows(const Sample* samples, I index, const std::int32_t (&of)[4], M m, Pair (&out)[4]) {
    alignas(32) std::int32_t at[kWidth];
    store(at, I::make(_mm256_and_si256(index.v, _mm256_castps_si256(m.v))));
#pragma GCC unroll 2
    for (int n = 0; n < 4; n += 2) {
        __m128i lanes[kWidth];
#pragma GCC unroll 8
        for (int lane = 0; lane < kWidth; ++lane) {
            const Sample* const from = samples + at[lane];
            lanes[lane] = _mm_unpacklo_epi64(_mm_loadu_si64(from + of[n]), _mm_loadu_si64(from + of[n + 1]));
        }
        I words[4];
        acrossLanes(lanes, words);
        out[n] = {words[0], words[1]}, out[n + 1] = {words[2], words[3]};
    }
}

TESSERA_LANE void rows4(const float* words, I index, F (&out)[4]) {
    alignas(32) std::int32_t at[kWidth];
    store(at, index);
    __m128i lanes[kWidth];
#pragma GCC unroll 8
    for (int lane = 0; lane < kWidth; ++lane)
        lanes[lane] = _mm_castps_si128(_mm_loadu_ps(words + at[lane]));
    I numbers[4];
    acrossLanes(lanes, numbers);
    for (int n = 0; n < 4; ++n)
        out[n] = asFloat(numbers[n]);
}

TESSERA_LANE __m256i lowestOnes(M m) {
    const std::uint64_t bytes = _pdep_u64(bits(m), 0x0101010101010101u) * 255u;
    const auto order = static_cast<long long>(_pext_u64(0x0706050403020100u, bytes));
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(order));
}
TESSERA_LANE F compress(F a, M m) {
    return F::make(_mm256_permutevar8x32_ps(a.v, lowestOnes(m)));
}
TESSERA_LANE I compress(I a, M m) {
    return I::make(_mm256_permutevar8x32_epi32(a.v, lowestOnes(m)));
}

} // namespace tessera::TESSERA_LANES::single

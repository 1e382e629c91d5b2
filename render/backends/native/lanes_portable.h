// render/backends/native/lanes_portable.h: lanes of the compiler's own vectors, four a register; where the
// compiler has no operation of its own, that of SSE2 or NEON. For lanes.h alone.
#pragma once

namespace tessera::TESSERA_LANES::single {

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
#if defined(__SSE2__)
    return static_cast<unsigned>(_mm_movemask_ps((__m128)a.v));
#elif defined(__aarch64__)
    return vaddvq_u32((uint32x4_t)(a.v & Ints{1, 2, 4, 8}));
#else
    unsigned all = 0;
    for (unsigned k = 0; k < kWidth; ++k)
        all |= (a.v[k] != 0 ? 1u : 0u) << k;
    return all;
#endif
}
TESSERA_LANE M fromBits(unsigned bits) {
    const Ints one{1, 2, 4, 8};
    return {((Ints{} + static_cast<std::int32_t>(bits)) & one) == one};
}
TESSERA_LANE F select(M m, F a, F b) {
    return F::make((Floats)(((Ints)a.v & m.v) | ((Ints)b.v & ~m.v)));
}
TESSERA_LANE I select(M m, I a, I b) {
    return I::make((Words)(((Ints)a.v & m.v) | ((Ints)b.v & ~m.v)));
}
TESSERA_LANE F sqrt(F a) {
#if defined(__SSE2__)
    return F::make(_mm_sqrt_ps(a.v));
#elif defined(__aarch64__)
    return F::make(vsqrtq_f32(a.v));
#else
    F r;
    for (int k = 0; k < kWidth; ++k)
        r.v[k] = __builtin_sqrtf(a.v[k]);
    return r;
#endif
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
/// Beyond 32 bits the result is some number, always the same.
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
            const char* const from =
                static_cast<const char*>(base) + std::int64_t{Scale} * static_cast<std::int32_t>(index.v[k]);
            if constexpr (Scale == sizeof words) { // whole: another thread may write it
                const std::uint64_t both =
                    __atomic_load_n(reinterpret_cast<const std::uint64_t*>(from), __ATOMIC_RELAXED);
                __builtin_memcpy(words, &both, sizeof words);
            } else {
                __builtin_memcpy(words, from, sizeof words);
            }
            r.low.v[k] = words[0];
            r.high.v[k] = words[1];
        }
    return r;
}

TESSERA_LANE void rows4(const float* words, I index, F (&out)[4]) {
    const auto row = [&](int lane) { return load(words + static_cast<std::int32_t>(index.v[lane])).v; };
    const Floats a = row(0), b = row(1), c = row(2), d = row(3);
    for (int n = 0; n < 4; ++n)
        out[n] = F::make(Floats{a[n], b[n], c[n], d[n]});
}

template <typename T> TESSERA_LANE T compress(T a, M m) {
    T r = a;
    int to = 0;
    for (int k = 0; k < kWidth; ++k)
        if (m.v[k] != 0)
            r.v[to++] = a.v[k];
    return r;
}

} // namespace tessera::TESSERA_LANES::single

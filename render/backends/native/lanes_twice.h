// render/backends/native/lanes_twice.h: two registers of lanes as one. While one of them waits for a load, or
// for a number that the next step needs, the other has work. For lanes.h alone.
#pragma once

namespace tessera::TESSERA_LANES {

constexpr int kWidth = 2 * single::kWidth;
struct M {
    single::M a, b;
};
struct F {
    single::F a, b;
    F() = default;
    __attribute__((always_inline)) F(single::F a, single::F b) : a(a), b(b) {}
    __attribute__((always_inline)) F(float x) : a(x), b(x) {}
};
struct I {
    single::I a, b;
    I() = default;
    __attribute__((always_inline)) I(single::I a, single::I b) : a(a), b(b) {}
    __attribute__((always_inline)) I(std::int32_t x) : a(x), b(x) {}
};

TESSERA_LANE F load(const float* p) {
    return {single::load(p), single::load(p + single::kWidth)};
}
TESSERA_LANE I load(const std::int32_t* p) {
    return {single::load(p), single::load(p + single::kWidth)};
}
TESSERA_LANE void store(float* p, F x) {
    single::store(p, x.a), single::store(p + single::kWidth, x.b);
}
TESSERA_LANE void store(std::int32_t* p, I x) {
    single::store(p, x.a), single::store(p + single::kWidth, x.b);
}

#define TESSERA_TWICE_INFIX(Result, T, op)                                                                   \
    TESSERA_LANE Result operator op(T x, T y) {                                                              \
        return {x.a op y.a, x.b op y.b};                                                                     \
    }
TESSERA_TWICE_INFIX(F, F, +)
TESSERA_TWICE_INFIX(F, F, -)
TESSERA_TWICE_INFIX(F, F, *)
TESSERA_TWICE_INFIX(F, F, /)
TESSERA_TWICE_INFIX(M, F, <)
TESSERA_TWICE_INFIX(M, F, <=)
TESSERA_TWICE_INFIX(M, F, ==)
TESSERA_TWICE_INFIX(M, I, <)
TESSERA_TWICE_INFIX(M, I, ==)
TESSERA_TWICE_INFIX(I, I, +)
TESSERA_TWICE_INFIX(I, I, -)
TESSERA_TWICE_INFIX(I, I, *)
TESSERA_TWICE_INFIX(I, I, &)
TESSERA_TWICE_INFIX(I, I, |)
TESSERA_TWICE_INFIX(I, I, ^)
TESSERA_TWICE_INFIX(M, M, &)
TESSERA_TWICE_INFIX(M, M, |)
#undef TESSERA_TWICE_INFIX
#define TESSERA_TWICE_OF_ONE(Result, name, T)                                                                \
    TESSERA_LANE Result name(T x) {                                                                          \
        return {single::name(x.a), single::name(x.b)};                                                       \
    }
TESSERA_TWICE_OF_ONE(M, operator~, M)
TESSERA_TWICE_OF_ONE(F, sqrt, F)
TESSERA_TWICE_OF_ONE(F, floor, F)
TESSERA_TWICE_OF_ONE(F, ceil, F)
TESSERA_TWICE_OF_ONE(F, abs, F)
TESSERA_TWICE_OF_ONE(I, truncated, F)
TESSERA_TWICE_OF_ONE(F, number, I)
TESSERA_TWICE_OF_ONE(F, asFloat, I)
TESSERA_TWICE_OF_ONE(I, asInt, F)
#undef TESSERA_TWICE_OF_ONE
#define TESSERA_TWICE_OF_TWO(T, name)                                                                        \
    TESSERA_LANE T name(T x, T y) {                                                                          \
        return {single::name(x.a, y.a), single::name(x.b, y.b)};                                             \
    }
TESSERA_TWICE_OF_TWO(F, min)
TESSERA_TWICE_OF_TWO(F, max)
TESSERA_TWICE_OF_TWO(I, min)
TESSERA_TWICE_OF_TWO(I, max)
TESSERA_TWICE_OF_TWO(I, shl) // left; right with zeros; right with the sign
TESSERA_TWICE_OF_TWO(I, shr)
TESSERA_TWICE_OF_TWO(I, sar)
#undef TESSERA_TWICE_OF_TWO

TESSERA_LANE unsigned bits(M m) {
    return single::bits(m.a) | single::bits(m.b) << single::kWidth;
}
TESSERA_LANE M fromBits(unsigned bits) {
    return {single::fromBits(bits & ((1u << single::kWidth) - 1u)), single::fromBits(bits >> single::kWidth)};
}
TESSERA_LANE bool any(M m) {
    return single::bits(m.a | m.b) != 0;
}
TESSERA_LANE F select(M m, F x, F y) {
    return {single::select(m.a, x.a, y.a), single::select(m.b, x.b, y.b)};
}
TESSERA_LANE I select(M m, I x, I y) {
    return {single::select(m.a, x.a, y.a), single::select(m.b, x.b, y.b)};
}
/// 32 bits at base + Scale * index, of the lanes of m; 0 elsewhere.
template <int Scale> TESSERA_LANE I gather(const void* base, I index, M m) {
    return {single::gather<Scale>(base, index.a, m.a), single::gather<Scale>(base, index.b, m.b)};
}
/// 64 bits: the lower and the upper word.
struct Pair {
    I low, high;
};
template <int Scale> TESSERA_LANE Pair gatherPair(const void* base, I index, M m) {
    const single::Pair x = single::gatherPair<Scale>(base, index.a, m.a);
    const single::Pair y = single::gatherPair<Scale>(base, index.b, m.b);
    return {{x.low, y.low}, {x.high, y.high}};
}

/// Four words beside one another from words + index on. Of every lane: the index of each must be a place that
/// can be read.
TESSERA_LANE void rows4(const float* words, I index, F (&out)[4]) {
    single::F lower[4], upper[4];
    single::rows4(words, index.a, lower), single::rows4(words, index.b, upper);
    for (int n = 0; n < 4; ++n)
        out[n] = {lower[n], upper[n]};
}

} // namespace tessera::TESSERA_LANES

// render/backends/native/lanes_derived.h: operations derived from those of lanes, the same for one register
// as for two. For lanes.h alone, which includes it in the namespace of each.

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
/// A matrix of three by three, the same for all lanes.
struct Columns {
    const float* numbers; // column by column
    __attribute__((always_inline)) F3 operator[](int n) const {
        return {F(numbers[3 * n]), F(numbers[3 * n + 1]), F(numbers[3 * n + 2])};
    }
};

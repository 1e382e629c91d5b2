// render/backends/native/packet_cell.h: a place in a brick and the samples around it, the same for one
// register of lanes as for two: for packet_field.h alone, which includes it in the namespace of each.

/// Four samples beside one another.
struct Row4 {
    F a, b, c, d;
};
/// Of samples of 16 bits, two in a word.
template <SampleKind K> TESSERA_LANE Row4 row4Of(Pair four) {
    if constexpr (K == SampleKind::i16)
        return {number(sar<16>(shl<16>(four.low))), number(sar<16>(four.low)),
                number(sar<16>(shl<16>(four.high))), number(sar<16>(four.high))};
    else
        return {number(four.low & I(0xffff)), number(shr<16>(four.low)), number(four.high & I(0xffff)),
                number(shr<16>(four.high))};
}
template <SampleKind K> TESSERA_LANE Row4 row4(const void* samples, I index, M m) {
    if constexpr (K == SampleKind::f32) {
        const Row2 low = row2<K>(samples, index, m), high = row2<K>(samples, index + I(2), m);
        return {low.a, low.b, high.a, high.b};
    } else {
        return row4Of<K>(gatherPair<2>(samples, index, m));
    }
}

/// The brick that each lane is in; none at first.
template <bool Mixed> struct Here {
    static constexpr float kNowhere = Mixed ? 1e9f : 0.0f;
    F3 origin{F(kNowhere), F(kNowhere), F(kNowhere)}; // lattice coordinates of its first sample
    F3 low{F(1), F(1), F(1)}, high{F(0), F(0), F(0)}; // between them it needs no other brick; from origin on
    /// Mixed levels: beyond these, along two axes or three, it does, all the same.
    F3 innerLow{F(1), F(1), F(1)}, innerHigh{F(0), F(0), F(0)};
    I base{0};
    F perVoxel{1};      // samples
    F row{0}, slice{0}; // pitches
};

/// Where all bricks are of one level, what they have in common.
template <bool Mixed> TESSERA_LANE Here<Mixed> hereAtFirst(const PacketField& f) {
    Here<Mixed> here;
    if constexpr (!Mixed) {
        here.perVoxel = asFloat(shl<23>(I(127 - f.level)));
        here.row = F(static_cast<float>(f.rowPitch[f.level]));
        here.slice = F(static_cast<float>(f.slicePitch[f.level]));
    }
    return here;
}

TESSERA_LANE M within(F3 x, F3 low, F3 high) {
    return (low.x <= x.x) & (low.y <= x.y) & (low.z <= x.z) & (x.x < high.x) & (x.y < high.y) &
           (x.z < high.z);
}

/// Along which axes a lane is not beyond its brick's inner box.
struct Inner {
    M x, y, z;
    /// But for one of them at most: then, inside low and high, no other brick has weight.
    __attribute__((always_inline)) M enough() const { return (x & y) | (z & (x | y)); }
};
template <bool Mixed> TESSERA_LANE Inner innerOf(const Here<Mixed>& here, F3 x) {
    return {(here.innerLow.x <= x.x) & (x.x < here.innerHigh.x),
            (here.innerLow.y <= x.y) & (x.y < here.innerHigh.y),
            (here.innerLow.z <= x.z) & (x.z < here.innerHigh.z)};
}
/// Lanes whose value needs no other brick.
/// @param x  inBrick()
template <bool Mixed> TESSERA_LANE M isHere(const Here<Mixed>& here, F3 x) {
    const M inside = within(x, here.low, here.high);
    if constexpr (Mixed)
        return inside & innerOf(here, x).enough();
    else
        return inside;
}

/// Samples of the lattice from the brick's first one: exact, whatever p is (the numbers below the point are
/// those of p, or fewer).
template <bool Mixed> TESSERA_LANE F3 inBrick(const Here<Mixed>& here, F3 p) {
    return here.perVoxel * p - here.origin;
}

template <bool Mixed> TESSERA_LANE I indexOf(const Here<Mixed>& here, F3 cell) {
    return here.base + truncated((cell.z * here.slice + cell.y * here.row) + cell.x);
}

/// Places of four rows, from one that a lane has an index of.
struct RowPlaces {
    int rows[4], slices[4]; // -1 to 2
};
constexpr RowPlaces kOfCell{{0, 1, 0, 1}, {0, 0, 1, 1}}, kBesideAlongY{{-1, -1, 2, 2}, {0, 1, 0, 1}},
    kBesideAlongZ{{0, 1, 0, 1}, {-1, -1, 2, 2}};

/// The same in samples, of lanes whose bricks are of one level.
struct RowOffsets {
    std::int32_t of[4];
    __attribute__((always_inline)) RowOffsets(const PacketField& f, const RowPlaces& places) {
        for (int n = 0; n < 4; ++n)
            of[n] = places.rows[n] * f.rowPitch[f.level] + places.slices[n] * f.slicePitch[f.level];
    }
};
template <SampleKind K> using Stored = std::conditional_t<K == SampleKind::i16, std::int16_t, std::uint16_t>;
/// By loads, where these are faster: not of mixed levels, whose lanes have pitches of their own.
template <SampleKind K, bool Mixed> constexpr bool kRowsByLoads = kLoadsRows&& K != SampleKind::f32 && !Mixed;
/// Between two samples of each of four rows.
/// @param index, part  of the first one at its row's place; way to the other
template <SampleKind K>
TESSERA_LANE void betweenInRows(const PacketField& f, I index, F part, const RowPlaces& places, M m,
                                F (&out)[4]) {
    I words[4];
    loadRows(static_cast<const Stored<K>*>(f.samples), index, RowOffsets(f, places).of, m, words);
    for (int n = 0; n < 4; ++n) {
        const Row2 row = row2Of<K>(words[n]);
        out[n] = leaf::partWay(row.a, row.b, part);
    }
}

/// The rows along x that hold a cell's corners, a sample longer at either end, by slice and row. A value and
/// a central difference at one place share them.
struct LongRows {
    Row4 r00, r01, r10, r11;
};
/// @param left  index of the sample before the cell's first
template <SampleKind K, bool Mixed>
TESSERA_LANE LongRows longRows(const PacketField& f, const Here<Mixed>& here, I left, M m) {
    // HostPlane::kAround: no row leaves the memory, whoever's samples it has
    if constexpr (kRowsByLoads<K, Mixed>) {
        Pair words[4];
        loadRows(static_cast<const Stored<K>*>(f.samples), left, RowOffsets(f, kOfCell).of, m, words);
        return {row4Of<K>(words[0]), row4Of<K>(words[1]), row4Of<K>(words[2]), row4Of<K>(words[3])};
    } else {
        const I row = truncated(here.row), slice = truncated(here.slice);
        const void* const s = f.samples;
        return {row4<K>(s, left, m), row4<K>(s, left + row, m), row4<K>(s, left + slice, m),
                row4<K>(s, left + (slice + row), m)};
    }
}

/// The value of lanes that need no other brick.
/// @param x  inBrick()
/// @param rows  null, or takes the rows of these lanes' cells; those of other lanes have no meaning
template <SampleKind K, bool Mixed>
TESSERA_LANE F valueHere(const PacketField& f, const Here<Mixed>& here, F3 x, M m, LongRows* rows) {
    const F3 cell{floor(x.x), floor(x.y), floor(x.z)};
    const F3 part = x - cell;
    const I index = indexOf(here, cell);
    if (rows) {
        *rows = longRows<K>(f, here, index - I(1), m);
        const LongRows& r = *rows;
        return leaf::trilinear(r.r00.b, r.r00.c, r.r01.b, r.r01.c, r.r10.b, r.r10.c, r.r11.b, r.r11.c, part.x,
                               part.y, part.z);
    }
    if constexpr (kRowsByLoads<K, Mixed>) {
        F r[4];
        betweenInRows<K>(f, index, part.x, kOfCell, m, r);
        return leaf::partWay(leaf::partWay(r[0], r[1], part.y), leaf::partWay(r[2], r[3], part.y), part.z);
    } else {
        const I row = truncated(here.row), slice = truncated(here.slice);
        const Row2 r00 = row2<K>(f.samples, index, m), r01 = row2<K>(f.samples, index + row, m);
        const Row2 r10 = row2<K>(f.samples, index + slice, m),
                   r11 = row2<K>(f.samples, index + (slice + row), m);
        return leaf::trilinear(r00.a, r00.b, r01.a, r01.b, r10.a, r10.b, r11.a, r11.b, part.x, part.y,
                               part.z);
    }
}

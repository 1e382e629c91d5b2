// render/backends/native/packet_cell.h: a place in a brick and the samples around it, the same for one
// register of lanes as for two: for packet_field.h alone, which includes it in the namespace of each.

/// Four samples beside one another.
struct Row4 {
    F a, b, c, d;
};
template <SampleKind K> TESSERA_LANE Row4 row4Of(const Pair& words) {
    const Row2 low = row2Of<K>(words.low), high = row2Of<K>(words.high);
    return {low.a, low.b, high.a, high.b};
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

// render/backends/native/packet_samples.h: samples beside one another, the same for one register of lanes as
// for two: for packet_blend.h alone, which includes it in the namespace of each.

/// Half a sample of a level, in voxels: exact.
TESSERA_LANE F halfSample(I level) {
    return asFloat(shl<23>(I(126) + level));
}
TESSERA_LANE F samplesPerVoxel(I level) {
    return asFloat(shl<23>(I(127) - level));
}

/// Two samples beside one another.
struct Row2 {
    F a, b;
};
/// Of samples of 16 bits, the first in the lower half of a word.
template <SampleKind K> TESSERA_LANE Row2 row2Of(I word) {
    if constexpr (K == SampleKind::i16)
        return {number(sar<16>(shl<16>(word))), number(sar<16>(word))};
    else
        return {number(word & I(0xffff)), number(shr<16>(word))};
}
template <SampleKind K> TESSERA_LANE Row2 row2(const void* samples, I index, M m) {
    if constexpr (K == SampleKind::f32) {
        const Pair pair = gatherPair<4>(samples, index, m);
        return {asFloat(pair.low), asFloat(pair.high)};
    } else {
        return row2Of<K>(gather<2>(samples, index, m));
    }
}

/// Samples from a row of a brick to the next; a slice is as many rows.
TESSERA_LANE I rowPitch(const PacketField& f, I level) {
    return select(level == I(0), I(f.rowPitch[0]), shr(I(32), level));
}

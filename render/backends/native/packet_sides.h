// render/backends/native/packet_sides.h: the six values of central differences, the same for one register of
// lanes as for two: for packet_gradient.h alone, which includes it in the namespace of each.

/// The values that differences are made of: at sides of p as side() numbers them.
struct Sides {
    F value[6];
    M known[6];
};

/// Values for central differences of lanes whose own cell lies in their brick: all that lie there too, from
/// one neighbourhood of 4^3 samples. If rounding says otherwise, or a value is another brick's, it is not
/// known.
/// @param rows  null, or those of the lanes' cells
template <SampleKind K, bool Mixed>
TESSERA_LANE void centralHere(const PacketField& f, const Here<Mixed>& here, F3 p, F3 x, F h, M m, Sides& to,
                              const LongRows* rows) {
    using leaf::partWay;
    const F one(1.0f);
    const F3 cell{floor(x.x), floor(x.y), floor(x.z)};
    const F3 part = x - cell;
    const F3 ahead = inBrick(here, F3{p.x + h, p.y + h, p.z + h});
    const F3 behind = inBrick(here, F3{p.x - h, p.y - h, p.z - h});
    const F3 up{floor(ahead.x), floor(ahead.y), floor(ahead.z)};
    const F3 down{floor(behind.x), floor(behind.y), floor(behind.z)};
    to.known[0] = m & (up.x == cell.x + one) & (ahead.x < here.high.x);
    to.known[1] = m & (down.x == cell.x - one) & (here.low.x <= behind.x);
    to.known[2] = m & (up.y == cell.y + one) & (ahead.y < here.high.y);
    to.known[3] = m & (down.y == cell.y - one) & (here.low.y <= behind.y);
    to.known[4] = m & (up.z == cell.z + one) & (ahead.z < here.high.z);
    to.known[5] = m & (down.z == cell.z - one) & (here.low.z <= behind.z);
    if constexpr (Mixed) {
        const Inner at = innerOf(here, x), above = innerOf(here, ahead), below = innerOf(here, behind);
        to.known[0] = to.known[0] & Inner{above.x, at.y, at.z}.enough();
        to.known[1] = to.known[1] & Inner{below.x, at.y, at.z}.enough();
        to.known[2] = to.known[2] & Inner{at.x, above.y, at.z}.enough();
        to.known[3] = to.known[3] & Inner{at.x, below.y, at.z}.enough();
        to.known[4] = to.known[4] & Inner{at.x, at.y, above.z}.enough();
        to.known[5] = to.known[5] & Inner{at.x, at.y, below.z}.enough();
    }
    const F3 partUp = ahead - up, partDown = behind - down;
    const I index = indexOf(here, cell);
    const auto [r00, r01, r10, r11] = rows ? *rows : longRows<K>(f, here, index - I(1), m);
    to.value[0] =
        leaf::trilinear(r00.c, r00.d, r01.c, r01.d, r10.c, r10.d, r11.c, r11.d, partUp.x, part.y, part.z);
    to.value[1] =
        leaf::trilinear(r00.a, r00.b, r01.a, r01.b, r10.a, r10.b, r11.a, r11.b, partDown.x, part.y, part.z);
    const F c00 = partWay(r00.b, r00.c, part.x), c01 = partWay(r01.b, r01.c, part.x);
    const F c10 = partWay(r10.b, r10.c, part.x), c11 = partWay(r11.b, r11.c, part.x);
    const I row = truncated(here.row), slice = truncated(here.slice);
    const auto along = [&](I at) {
        const Row2 r = row2<K>(f.samples, at, m);
        return partWay(r.a, r.b, part.x);
    };
    F y0, y1, y2, y3, z0, z1, z2, z3;
    if constexpr (kRowsByLoads<K, Mixed>) {
        F between[4];
        betweenInRows<K>(f, index, part.x, kBesideAlongY, m, between);
        y0 = between[0], y1 = between[1], y2 = between[2], y3 = between[3];
    } else {
        const I row2nd = row + row;
        y0 = along(index - row), y1 = along(index + (slice - row));
        y2 = along(index + row2nd), y3 = along(index + (slice + row2nd));
    }
    to.value[2] = partWay(partWay(c01, y2, partUp.y), partWay(c11, y3, partUp.y), part.z);
    to.value[3] = partWay(partWay(y0, c00, partDown.y), partWay(y1, c10, partDown.y), part.z);
    if constexpr (kRowsByLoads<K, Mixed>) {
        F between[4];
        betweenInRows<K>(f, index, part.x, kBesideAlongZ, m, between);
        z0 = between[0], z1 = between[1], z2 = between[2], z3 = between[3];
    } else {
        const I slice2nd = slice + slice;
        z0 = along(index - slice), z1 = along(index + (row - slice));
        z2 = along(index + slice2nd), z3 = along(index + (slice2nd + row));
    }
    const F middle0 = partWay(c00, c01, part.y), middle1 = partWay(c10, c11, part.y);
    to.value[4] = partWay(middle1, partWay(z2, z3, part.y), partUp.z);
    to.value[5] = partWay(partWay(z0, z1, part.y), middle0, partDown.z);
}

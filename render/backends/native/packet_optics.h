// render/backends/native/packet_optics.h: colour, opacity and shading of values, and contributions of
// segments, for all lanes of a packet, as render/contract/optics.h and integrators.h
// have them, from the same leaves. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_field.h"
#include "render/contract/leaves.h"

namespace tessera::TESSERA_LANES {

using native::PacketIntegrator;
using native::PacketOptics;

TESSERA_LANE F placeOf(const PacketOptics& o, F stored) {
    return leaf::farPlaceOf(stored, F(o.scale), F(o.offset));
}

/// The two entries around a place, and how far it is from the first.
struct Entries {
    I first;
    F part;
};
/// Places that are no numbers count as the first one.
TESSERA_LANE Entries entriesAt(const PacketOptics& o, F place) {
    const F x = leaf::heldPlace(place, F(o.lastPlace));
    const I first = min(truncated(x), I(o.lastEntry));
    return {first, x - number(first)};
}
/// entriesAt(placeOf()), which limits places once.
TESSERA_LANE Entries entriesOf(const PacketOptics& o, F stored) {
    return entriesAt(o, stored * F(o.scale) + F(o.offset));
}
/// The table's content there.
struct TableLook {
    F3 colour;
    F extinction; // per mm
};
TESSERA_LANE TableLook lookUp(const PacketOptics& o, Entries at) {
    F first[4], next[4];
    const I index = shl<2>(at.first);
    rows4(o.table, index, first), rows4(o.table + 4, index, next);
    const auto between = [&](int n) { return leaf::partWay(first[n], next[n], at.part); };
    return {{between(0), between(1), between(2)}, between(3)};
}

/// One end of a segment. Pre-integration also needs its bin.
struct End {
    F place{0.0f};
    I bin{0};
    F x{0.0f}, y{0.0f}, z{0.0f}, w{0.0f};
};
TESSERA_LANE F word(const float* words, I index, M m) {
    return asFloat(gather<4>(words, index, m));
}
/// lookUp() of the extinction alone, of lanes m.
TESSERA_LANE F extinctionOf(const PacketOptics& o, Entries at, M m) {
    const I index = shl<2>(at.first);
    return leaf::partWay(word(o.table + 3, index, m), word(o.table + 7, index, m), at.part);
}
TESSERA_LANE End endOf(const PacketOptics& o, F stored, M m) {
    End end;
    end.place = placeOf(o, stored);
    if (o.integrator == PacketIntegrator::preintegrated ||
        o.integrator == PacketIntegrator::preintegrated2d) {
        end.bin = min(max(truncated(floor(end.place)), I(-1)), I(o.last));
        const I at = shl<2>(end.bin + I(1));
        const Pair low = gatherPair<4>(o.bins, at, m), high = gatherPair<4>(o.bins, at + I(2), m);
        end.x = asFloat(low.low), end.y = asFloat(low.high);
        end.z = asFloat(high.low), end.w = asFloat(high.high);
    }
    return end;
}
TESSERA_LANE End select(M m, const End& a, const End& b) {
    return {select(m, a.place, b.place), select(m, a.bin, b.bin), select(m, a.x, b.x),
            select(m, a.y, b.y),         select(m, a.z, b.z),     select(m, a.w, b.w)};
}

/// Extinction of segments that are given by their ends, per mm.
TESSERA_LANE F extinctionBetween(const PacketOptics& o, const End& front, const End& back) {
    if (o.integrator == PacketIntegrator::linear)
        return F(0.5f) * (lookUp(o, entriesAt(o, front.place)).extinction +
                          lookUp(o, entriesAt(o, back.place)).extinction);
    const M rises = front.place < back.place;
    const End low = select(rises, front, back), high = select(rises, back, front);
    const auto binEnd = [](const End& e) {
        return leaf::BinEnd<F>{e.place, number(e.bin), e.x, e.y, e.z, e.w};
    };
    return leaf::meanExtinction(binEnd(low), binEnd(high));
}

/// Of depths. Thin media rarely leave the polynomial for small ones.
TESSERA_LANE F opacityOf(F depth, M m) {
    const M deep = m & ~(depth < F(leaf::kOneMinusExpBelow));
    const F opacity = leaf::oneMinusExpBelow(depth);
    return any(deep) ? select(deep, leaf::oneMinusExpAbove(depth), opacity) : opacity;
}

/// Colour, averaged over the values between two ends by their extinction.
TESSERA_LANE F3 meanColour(const PacketOptics& o, const End& front, const End& back, M m) {
    const M rises = front.place < back.place;
    const End low = select(rises, front, back), high = select(rises, back, front);
    const F half(0.5f);
    const F3 middle = lookUp(o, entriesAt(o, half * (low.place + high.place))).colour;
    struct Radiance {
        F3 colour;
        F weight;
    };
    const auto radiance = [&](F width, F place) {
        const TableLook look = lookUp(o, entriesAt(o, place));
        const F weight = width * look.extinction;
        return Radiance{weight * look.colour, weight};
    };
    const F next = number(low.bin + I(1)), start = number(high.bin);
    const Radiance below = radiance(next - low.place, half * (low.place + next));
    const Radiance above = radiance(high.place - start, half * (start + high.place));
    const auto sumTo = [&](I bin, int part, int component) {
        return word(o.sums, shl<3>(bin + I(1)) + I(4 * part + component), m);
    };
    const auto sum = [&](F under, F over, int component) {
        return leaf::sumOverBins(under, sumTo(low.bin + I(1), 0, component),
                                 sumTo(low.bin + I(1), 1, component), sumTo(high.bin, 0, component),
                                 sumTo(high.bin, 1, component), over);
    };
    const F weight = sum(below.weight, above.weight, 3);
    const F3 colour{sum(below.colour.x, above.colour.x, 0) / weight,
                    sum(below.colour.y, above.colour.y, 1) / weight,
                    sum(below.colour.z, above.colour.z, 2) / weight};
    const M one = (low.bin == high.bin) | ~(weight > F(1e-30f));
    return select(one, middle, colour);
}

/// From the table of two-dimensional pre-integration.
/// @param stride  log2 of the stride's segments
TESSERA_LANE F3 tabledColour(const PacketOptics& o, F front, F back, I stride, M m) {
    const F last(o.lastPlace), scale(o.preintegrationScale);
    const F x = leaf::heldPlace(front, last) * scale, y = leaf::heldPlace(back, last) * scale;
    const int edge = o.preintegrationEdge;
    const I i = min(truncated(x), I(edge - 2)), j = min(truncated(y), I(edge - 2));
    const F fx = x - number(i), fy = y - number(j);
    const I at = shl<2>(((stride - I(o.firstLayer)) * I(edge) + j) * I(edge) + i);
    const auto corner = [&](int offset) {
        const auto component = [&](int n) { return word(o.colours, at + I(4 * offset + n), m); };
        return F3{component(0), component(1), component(2)};
    };
    return leaf::bilinear(corner(0), corner(1), corner(edge), corner(edge + 1), fx, fy);
}

TESSERA_LANE F3 colourBetween(const PacketOptics& o, const End& front, const End& back, F depth, F alpha,
                              I stride, M m) {
    if (o.integrator == PacketIntegrator::preintegrated2d)
        return tabledColour(o, front.place, back.place, stride, m);
    if (o.integrator == PacketIntegrator::preintegrated)
        return meanColour(o, front, back, m);
    const F3 a = lookUp(o, entriesAt(o, front.place)).colour, b = lookUp(o, entriesAt(o, back.place)).colour;
    return leaf::partWay(a, b, leaf::seenDepth(depth, alpha));
}

TESSERA_LANE F3 transformed(const float* columns, F3 v) {
    return leaf::transformed(Columns{columns}, v);
}

/// Gradient opacity: factors on extinctions.
/// @param gradient  voxel space
inline __attribute__((noinline)) F gradientFactor(const PacketOptics& o, const F3& gradient) {
    return leaf::gradientOpacity<F>(o.gradientOpacity, transformed(o.toGradient, gradient), F(kMostFloat));
}

/// @param direction  patient space
TESSERA_LANE F3 shaded(const PacketOptics& o, F3 colour, F3 gradient, F3 direction) {
    const F3 g = transformed(o.toGradient, gradient);
    const M isLit = leaf::isHeadLit(g, direction, F(kMostFloat));
    const auto light = leaf::headLight(g, direction, F(o.ambient), F(o.diffuse), F(o.specular), o.power);
    const F3 lit{colour.x * light.scale + light.add, colour.y * light.scale + light.add,
                 colour.z * light.scale + light.add};
    return select(isLit, lit, colour);
}

/// leaf::wholePower() with a power a lane.
TESSERA_LANE F wholePower(F x, I n) {
    F result(1.0f), square = x;
    for (int bit = 0; bit <= 10; ++bit) { // 1024 at most
        result = select((n & I(1 << bit)) == I(0), result, result * square);
        square = square * square;
    }
    return result;
}

/// Of values at places in the table.
TESSERA_LANE leaf::Material<F, I> materialAt(const PacketOptics& o, F place) {
    leaf::Material<F, I> material{F(o.ambient), F(o.diffuse), F(o.specular), I(o.power)};
    for (int i = 0; i < o.materialCount; ++i) {
        const leaf::MaterialNumbers& m = o.materials[i];
        const M here = (place >= F(m.from)) & (place < F(m.to));
        material = {select(here, F(m.ambient), material.ambient),
                    select(here, F(m.diffuse), material.diffuse),
                    select(here, F(m.specular), material.specular), select(here, I(m.power), material.power)};
    }
    return material;
}

/// Emission of such values.
/// @param place  in the table
TESSERA_LANE F3 emissionAt(const PacketOptics& o, F place) {
    F3 sent{F(0.0f), F(0.0f), F(0.0f)};
    for (int i = 0; i < o.materialCount; ++i) {
        const leaf::MaterialNumbers& m = o.materials[i];
        const M here = (place >= F(m.from)) & (place < F(m.to));
        sent = select(here, F3{F(m.emission[0]), F(m.emission[1]), F(m.emission[2])}, sent);
    }
    return sent;
}

/// By the scene's own lights.
/// @param direction  patient space
/// @param middle, place  of the samples: voxels; of their values, for materials
template <typename Received>
inline __attribute__((noinline)) F3 shadedByLights(const PacketOptics& o, const F3& colour,
                                                   const F3& gradient, const F3& direction, const F3& middle,
                                                   const F& place, const Received& received) {
    const F3 g = transformed(o.toGradient, gradient);
    const auto toPoint = [&](const leaf::LightNumbers& light) {
        return transformed(o.toPatient, {F(light.place[0]) - middle.x, F(light.place[1]) - middle.y,
                                         F(light.place[2]) - middle.z});
    };
    const auto by = [&](const auto& material) {
        const auto lit = leaf::litBy<F>(o.lighting, g, direction, material, F(kMostFloat), toPoint, received);
        return F3{colour.x * lit.scale[0] + lit.add[0], colour.y * lit.scale[1] + lit.add[1],
                  colour.z * lit.scale[2] + lit.add[2]};
    };
    if (o.materialCount == 0)
        return by(leaf::Material<F>{F(o.ambient), F(o.diffuse), F(o.specular), o.power});
    const F3 lit = by(materialAt(o, place));
    return o.lighting.emits ? lit + emissionAt(o, place) : lit;
}

} // namespace tessera::TESSERA_LANES

// render/contract/leaves.h: the innermost arithmetic of docs/sampling.md, one text for every kind of number
// and for both languages. The files leaf_*.h hold it. C++ reads them here, as templates over V: float and
// double, one at a time, and the native engine's lanes of floats. Shaders read the same files with V a float,
// by shaders/common_leaves.glsl, which has the words below in GLSL. So a leaf takes no reference but by
// LEAF_IN, LEAF_OUT and LEAF_INOUT, calls functions of both languages, and names nothing by a word of GLSL
// (half, smooth, sample). Every number that it computes is a LEAF_LET, a LEAF_LET3 or a LEAF_VAR, which GLSL
// takes for precise: the order of operations is part of the contract. A choice is a select() here in place of
// an `if`: both sides are computed.
//
// Lanes bring select(), min(), max(), sqrt(), floor(), ceil(), abs() and powerOfTwo() of their own.
#pragma once

#include "render/contract/scene_numbers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>

/// Calls would cost lanes more than what is called.
#if TESSERA_SANITIZED
#define TESSERA_LEAF inline
#else
#define TESSERA_LEAF inline __attribute__((always_inline))
#endif

// Types of a function's arguments: numbers V, vectors Vec of three, a matrix Mat by columns, codes of bricks
// (whole numbers), or plain ones; Bool is a condition on them. LEAF_MAKE(Struct, (parts)) makes a
// LEAF_STRUCT.
#define LEAF template <typename V, typename Bool = Condition<V>> TESSERA_LEAF
#define LEAF_OF_VEC                                                                                          \
    template <typename Vec, typename V = Number<Vec>, typename Bool = Condition<V>> TESSERA_LEAF
#define LEAF_OF_MATRIX template <typename Mat, typename Vec> TESSERA_LEAF
#define LEAF_OF_CODE template <typename Code, typename Bool> TESSERA_LEAF
#define LEAF_PLAIN TESSERA_LEAF
#define LEAF_STRUCT template <typename V> struct
#define LEAF_OF(Struct) Struct<V>
#define LEAF_LET const V
#define LEAF_LET3 const Vec
#define LEAF_VAR V
#define LEAF_VEC3(x, y, z)                                                                                   \
    Vec {                                                                                                    \
        x, y, z                                                                                              \
    }
#define LEAF_MAKE(Struct, parts) Struct<V> LEAF_BRACED parts
#define LEAF_BRACED(...)                                                                                     \
    { __VA_ARGS__ }
#define LEAF_IN(Type) const Type&
#define LEAF_OUT(Type) Type&
#define LEAF_INOUT(Type) Type&

namespace tessera::leaf {

template <typename Vec> using Number = std::remove_cvref_t<decltype(std::declval<const Vec&>().x)>;
template <typename V> using Condition = decltype(std::declval<V>() > std::declval<V>());

using std::abs, std::ceil, std::floor, std::max, std::min, std::sqrt;

template <typename T>
requires std::is_arithmetic_v<T>
constexpr T select(bool condition, T a, T b) {
    return condition ? a : b;
}
template <typename Bool> TESSERA_LEAF Bool both(Bool a, Bool b) {
    return a & b;
}
template <typename Bool> TESSERA_LEAF Bool either(Bool a, Bool b) {
    return a | b;
}
/// 2^n of a whole n from -126 to 127.
inline float powerOfTwo(float n) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(static_cast<int>(n) + 127) << 23);
}

#include "render/contract/leaf_vector.h"

#include "render/contract/leaf_bricks.h"
#include "render/contract/leaf_cubic.h"
#include "render/contract/leaf_field.h"
#include "render/contract/leaf_fusion.h"
#include "render/contract/leaf_labels.h"
#include "render/contract/leaf_light.h"
#include "render/contract/leaf_opacity.h"
#include "render/contract/leaf_ray.h"
#include "render/contract/leaf_surface.h"
#include "render/contract/leaf_table.h"

// Text for C++ alone: loops that a shader writes with turns of its own, and choices by type.

/// The derivative per sample along x, y and z.
/// @param row  row(y, z, r) fills r[4] with the samples of a row, y and z from 0 to 3
template <typename V, typename Vec, typename Row>
TESSERA_LEAF Vec cubicGradient(V fx, V fy, V fz, const Row& row) {
    const CubicWeights<V> wx = cubicWeights(fx), wy = cubicWeights(fy), wz = cubicWeights(fz);
    V alongX[4], alongY[4], smooth[4];
    for (int z = 0; z < 4; ++z) {
        V step[4], value[4];
        for (int y = 0; y < 4; ++y) {
            V r[4];
            row(y, z, r);
            step[y] = cubicStep(wx, r[0], r[1], r[2], r[3]);
            value[y] = cubicValue(wx, r[0], r[1], r[2], r[3]);
        }
        alongX[z] = cubicValue(wy, step[0], step[1], step[2], step[3]);
        alongY[z] = cubicStep(wy, value[0], value[1], value[2], value[3]);
        smooth[z] = cubicValue(wy, value[0], value[1], value[2], value[3]);
    }
    return {cubicValue(wz, alongX[0], alongX[1], alongX[2], alongX[3]),
            cubicValue(wz, alongY[0], alongY[1], alongY[2], alongY[3]),
            cubicStep(wz, smooth[0], smooth[1], smooth[2], smooth[3])};
}

template <typename V> TESSERA_LEAF V oneMinusExp(V x) {
    return select(x < V(kOneMinusExpBelow), oneMinusExpBelow(x), oneMinusExpAbove(x));
}

/// Gradient opacity.
/// @param g  the gradient, patient space, stored units per mm
/// @param points  one at least
template <typename V, typename Vec, typename N>
TESSERA_LEAF V gradientOpacity(const GradientNumbers<N>& points, const Vec& g, V largest) {
    const V steep = steepness(g, largest);
    V factor = static_cast<V>(points.factor[0]);
    for (int i = 0; i < points.count; ++i)
        factor = factorFrom(factor, steep, static_cast<V>(points.length[i]), static_cast<V>(points.factor[i]),
                            static_cast<V>(points.slope[i]));
    return heldToOne(factor);
}

/// All light reaches a sample: for scenes without occlusion and shadows, at no cost.
struct AllLight {
    template <typename V> TESSERA_LEAF V ambient(V reflected, int) const { return reflected; }
    template <typename V> TESSERA_LEAF V of(int, V light) const { return light; }
};
/// Shares of light that reach a sample.
template <typename V> struct ReceivedLight {
    V fromAllSides[3]; // ambient, by channel
    V from[kMostLights];
    TESSERA_LEAF V ambient(V reflected, int channel) const { return fromAllSides[channel] * reflected; }
    TESSERA_LEAF V of(int number, V light) const { return from[number] * light; }
};
/// From what voxels have.
/// @param light  of a channel: f(number)
template <typename V, typename Light>
TESSERA_LEAF ReceivedLight<V> receivedLight(const LightingNumbers& lighting, const Light& light) {
    const V one(1.0f);
    ReceivedLight<V> received{{one, one, one}, {one, one, one, one}};
    if (lighting.occlusionChannel >= 0) {
        if (lighting.ambientChannels == 1) {
            const V share = light(lighting.occlusionChannel);
            for (V& all : received.fromAllSides)
                all = share;
        } else {
            for (int c = 0; c < 3; ++c)
                received.fromAllSides[c] = light(lighting.occlusionChannel + c);
        }
    }
    for (int i = 0; i < lighting.count; ++i)
        if (lighting.lights[i].channel >= 0)
            received.from[i] = light(lighting.lights[i].channel);
    return received;
}

/// Where the labels of a sample at p are taken.
/// @param pitch  of the samples of the brick that p lies in, voxels, a power of two: f()
template <typename Vec, typename Pitch, typename V = Number<Vec>>
TESSERA_LEAF Vec placeOfLabels(const LabelNumbers& labels, const Vec& p, const Pitch& pitch) {
    if (!labels.nearest)
        return p;
    const V own = pitch(), perVoxel = V(1.0f) / own;
    return Vec{middleOfSample(p.x, own, perVoxel), middleOfSample(p.y, own, perVoxel),
               middleOfSample(p.z, own, perVoxel)};
}

/// A place along a normal.
template <typename V> TESSERA_LEAF V placeAcross(const CutSlab& slab, V x, V y, V z) {
    return V(slab.normal[0]) * x + V(slab.normal[1]) * y + V(slab.normal[2]) * z;
}
/// Where a volume's own cuts keep a place.
/// @param slabs  at least one; the last ends a body
template <typename Vec, typename V = Number<Vec>>
TESSERA_LEAF Condition<V> isKept(const CutSlab* slabs, int count, const Vec& p) {
    const auto anywhere = V(0.0f) <= V(0.0f);
    auto kept = anywhere, inside = anywhere;
    for (int n = 0; n < count; ++n) {
        const CutSlab& s = slabs[n];
        const V along = placeAcross<V>(s, p.x, p.y, p.z);
        inside = inside & (V(s.low) <= along) & (along <= V(s.high));
        if (s.endsBody) {
            const V outside = select(inside, V(0.0f), V(1.0f));
            kept = kept & (s.keepsOutside ? outside > V(0.0f) : inside);
            inside = anywhere;
        }
    }
    return kept;
}

/// From the channels that voxels have.
/// @param channel  its factor: f(number)
template <typename V, typename Channel>
TESSERA_LEAF LabelShares<V> labelShares(const LabelNumbers& labels, const Channel& channel) {
    const V zero(0.0f);
    LabelShares<V> shares{zero, zero, zero, zero, zero, zero, zero};
    if (labels.plain >= 0)
        shares.plain = channel(labels.plain);
    if (labels.tinted >= 0)
        shares.tinted = channel(labels.tinted);
    if (labels.solid >= 0)
        shares.solid = shares.dense = channel(labels.solid);
    if (labels.dense >= 0)
        shares.dense = channel(labels.dense);
    if (labels.colour >= 0) {
        shares.red = channel(labels.colour);
        shares.green = channel(labels.colour + 1);
        shares.blue = channel(labels.colour + 2);
    }
    return shares;
}

/// The gradient of the labels' medium.
/// @param solid  its share at a place, voxels: f(place)
template <typename V, typename Vec, typename Solid>
TESSERA_LEAF Vec mediumGradient(const Vec& p, const Solid& solid) {
    const V reach(kLabelReach);
    const auto between = [&](const Vec& before, const Vec& after) {
        const V low = solid(before), high = solid(after);
        return mediumSlope(low, high);
    };
    const V x = between(Vec{p.x - reach, p.y, p.z}, Vec{p.x + reach, p.y, p.z});
    const V y = between(Vec{p.x, p.y - reach, p.z}, Vec{p.x, p.y + reach, p.z});
    const V z = between(Vec{p.x, p.y, p.z - reach}, Vec{p.x, p.y, p.z + reach});
    return Vec{x, y, z};
}

/// @param N  of the power: a whole number, or one a lane
template <typename V, typename N = int> struct Material {
    V ambient, diffuse, specular;
    N power;
    V emission[3] = {V(0.0f), V(0.0f), V(0.0f)}; // is added to the result of litBy()
};
/// The effect of lights on colours: colour * scale + add, by channel.
template <typename V> struct Lit { V scale[3], add[3]; };

/// The light of docs/sampling.md, "Shading", by the scene's own lights.
/// @param gradient, direction  patient space, any scale
/// @param toPoint   from the sample to a point light, patient space, mm: f(LightNumbers)
/// @param received  shares of it that reach the sample: AllLight, or ReceivedLight<V>
template <typename V, typename Vec, typename N, typename ToPoint, typename Received>
TESSERA_LEAF Lit<V> litBy(const LightingNumbers& lighting, const Vec& g, const Vec& d,
                          const Material<V, N>& m, V largest, const ToPoint& toPoint,
                          const Received& received) {
    const V zero(0.0f), one(1.0f);
    Vec n{zero, zero, zero}, v{zero, zero, zero};
    const Met<V> met = meetLight(g, d, lighting.model, largest, n, v);
    V everywhere[3] = {zero, zero, zero}, facingIt[3] = {zero, zero, zero}, mirrored[3] = {zero, zero, zero};
    for (int i = 0; i < lighting.count; ++i) {
        const LightNumbers& light = lighting.lights[i];
        Vec l = v;
        V shares = one;
        if (light.sort == LightSort::directional)
            l = {V(light.place[0]), V(light.place[1]), V(light.place[2])};
        else if (light.sort == LightSort::point)
            meetPoint(toPoint(light), V(light.fading[0]), V(light.fading[1]), V(light.fading[2]), largest, l,
                      shares);
        shares = received.of(i, shares);
        const V slant = dot3(n, l);
        const V cosine = heldToOne(slant);
        const V highlight = wholePower(sharpness(n, v, l, slant, met, lighting.model), m.power);
        const V shine = select(slant > zero, highlight, zero);
        for (int c = 0; c < 3; ++c) {
            const V power = V(light.colour[c]) * shares;
            everywhere[c] = everywhere[c] + power;
            facingIt[c] = facingIt[c] + power * cosine;
            mirrored[c] = mirrored[c] + power * shine;
        }
    }
    const auto scale = [&](int c) {
        return litScale(met, received.ambient(m.ambient, c), m.diffuse, everywhere[c], facingIt[c]);
    };
    const auto add = [&](int c) { return litAdd(met, m.specular, mirrored[c]); };
    return {{scale(0), scale(1), scale(2)}, {add(0), add(1), add(2)}};
}

} // namespace tessera::leaf

// render/contract/leaves.h: the innermost arithmetic of docs/sampling.md, one text for every kind of number:
// float and double, one at a time, and the native engine's lanes of floats. What is an `if` elsewhere is a
// select() here: both sides are computed. The order of operations is part of the contract.
//
// V: a number; lanes bring select(), min(), max(), sqrt(), floor(), abs() and powerOfTwo() of their own.
#pragma once

#include "render/contract/gradient_numbers.h"
#include "render/contract/light_numbers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

/// Calls would cost lanes more than what is called.
#if TESSERA_SANITIZED
#define TESSERA_LEAF inline
#else
#define TESSERA_LEAF inline __attribute__((always_inline))
#endif

namespace tessera::leaf {

constexpr float select(bool condition, float a, float b) {
    return condition ? a : b;
}
constexpr double select(bool condition, double a, double b) {
    return condition ? a : b;
}
/// 2^n of a whole n from -126 to 127.
inline float powerOfTwo(float n) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(static_cast<int>(n) + 127) << 23);
}

template <typename V> TESSERA_LEAF V mix(V a, V b, V f) {
    return a + f * (b - a);
}

/// Between the eight samples of a cell; vzyx.
template <typename V>
TESSERA_LEAF V trilinear(V v000, V v001, V v010, V v011, V v100, V v101, V v110, V v111, V fx, V fy, V fz) {
    const V a = mix(v000, v001, fx), b = mix(v010, v011, fx);
    const V c = mix(v100, v101, fx), d = mix(v110, v111, fx);
    return mix(mix(a, b, fy), mix(c, d, fy), fz);
}

/// Cubic B-splines about a place in a cell, of the samples -1, 0, 1, 2: `value` of each, and what the
/// derivative takes of the differences between each and the next: so it is exactly 0 where all are the same.
template <typename V> struct CubicWeights { V value[4], step[3]; };
template <typename V> TESSERA_LEAF CubicWeights<V> cubicWeights(V f) {
    const V one(1.0f), half(0.5f), sixth = one / V(6.0f);
    const V g = one - f, ff = f * f, gg = g * g;
    const V first = sixth * gg * g, last = sixth * ff * f;
    const V low = V(2.0f) / V(3.0f) - ff * (one - half * f);
    return {{first, low, ((one - first) - low) - last, last}, {half * gg, half + f * g, half * ff}};
}
/// Of four samples in a row, or of four rows that are smoothed.
template <typename V> TESSERA_LEAF V cubicValue(const CubicWeights<V>& w, V a, V b, V c, V d) {
    return w.value[0] * a + w.value[1] * b + w.value[2] * c + w.value[3] * d;
}
template <typename V> TESSERA_LEAF V cubicStep(const CubicWeights<V>& w, V a, V b, V c, V d) {
    return w.step[0] * (b - a) + w.step[1] * (c - b) + w.step[2] * (d - c);
}
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

/// 1 - exp(-x) in float, x not negative: a polynomial below 1/4, a written-out exponential above.
template <typename V> TESSERA_LEAF V oneMinusExpBelow(V x) {
    const V one(1.0f);
    return x * (one - x * V(1.0f / 2.0f) *
                          (one - x * V(1.0f / 3.0f) *
                                     (one - x * V(1.0f / 4.0f) *
                                                (one - x * V(1.0f / 5.0f) * (one - x * V(1.0f / 6.0f))))));
}
template <typename V> TESSERA_LEAF V oneMinusExpAbove(V x) {
    using std::floor, std::max;
    const V one(1.0f);
    const V y = max(x * V(-1.44269504f), V(-126.0f));
    const V n = floor(y);
    const V r = (y - n) * V(0.693147181f); // 2^(y-n) = e^r
    const V p =
        one +
        r * (one +
             r * V(1.0f / 2.0f) *
                 (one + r * V(1.0f / 3.0f) *
                            (one + r * V(1.0f / 4.0f) *
                                       (one + r * V(1.0f / 5.0f) *
                                                  (one + r * V(1.0f / 6.0f) *
                                                             (one + r * V(1.0f / 7.0f) *
                                                                        (one + r * V(1.0f / 8.0f))))))));
    return one - p * powerOfTwo(n);
}
constexpr float kOneMinusExpBelow = 0.25f;
template <typename V> TESSERA_LEAF V oneMinusExp(V x) {
    return select(x < V(kOneMinusExpBelow), oneMinusExpBelow(x), oneMinusExpAbove(x));
}

template <typename V> TESSERA_LEAF V wholePower(V x, int n) {
    V result(1.0f), square = x;
    for (; n > 0; n >>= 1) {
        if (n & 1)
            result = result * square;
        square = square * square;
    }
    return result;
}

/// What a head light makes of colours: colour * scale + add.
template <typename V> struct HeadLight { V scale, add; };
/// @param gradient, direction  patient space, any scale
/// @param isLit  gets where there is a light; elsewhere colours stay as they are
template <typename V, typename Vec, typename Condition>
TESSERA_LEAF HeadLight<V> headLight(const Vec& g, const Vec& d, V ambient, V diffuse, V specular, int power,
                                    V largest, Condition& isLit) {
    using std::abs, std::max, std::min, std::sqrt;
    const V lengths = (g.x * g.x + g.y * g.y + g.z * g.z) * (d.x * d.x + d.y * d.y + d.z * d.z);
    isLit = (lengths > V(0.0f)) & (lengths <= largest); // else no direction, or none that V can hold
    const V cosine = min(V(1.0f), abs(g.x * d.x + g.y * d.y + g.z * d.z) / sqrt(lengths));
    const V mirrored = max(V(0.0f), V(2.0f) * cosine * cosine - V(1.0f));
    return {ambient + diffuse * cosine, specular * wholePower(mirrored, power)};
}

/// Gradient opacity.
/// @param g  the gradient, patient space, stored units per mm
/// @param points  one at least
template <typename V, typename Vec, typename N>
TESSERA_LEAF V gradientOpacity(const GradientNumbers<N>& points, const Vec& g, V largest) {
    using std::max, std::min, std::sqrt;
    const V squared = g.x * g.x + g.y * g.y + g.z * g.z;
    const V length = sqrt(select(squared <= largest, squared, largest)); // also where it is no number
    V factor = static_cast<V>(points.factor[0]);
    for (int i = 0; i < points.count; ++i) {
        const V from = static_cast<V>(points.length[i]);
        factor = select(from <= length,
                        static_cast<V>(points.factor[i]) + (length - from) * static_cast<V>(points.slope[i]),
                        factor);
    }
    return min(V(1.0f), max(V(0.0f), factor));
}

/// All light reaches a sample: what scenes without occlusion and shadows receive, at no cost.
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

/// @param N  of the power: a whole number, or one a lane
template <typename V, typename N = int> struct Material {
    V ambient, diffuse, specular;
    N power;
    V emission[3] = {V(0.0f), V(0.0f), V(0.0f)}; // is added to what litBy() makes of a colour
};
/// What lights make of colours: colour * scale + add, by channel.
template <typename V> struct Lit { V scale[3], add[3]; };

/// The light of docs/sampling.md, "Shading", by the scene's own lights.
/// @param gradient, direction  patient space, any scale
/// @param toPoint   from the sample to a point light, patient space, mm: f(LightNumbers)
/// @param received  shares of it that reach the sample: AllLight, or ReceivedLight<V>
template <typename V, typename Vec, typename N, typename ToPoint, typename Received>
TESSERA_LEAF Lit<V> litBy(const LightingNumbers& lighting, const Vec& g, const Vec& d,
                          const Material<V, N>& m, V largest, const ToPoint& toPoint,
                          const Received& received) {
    using std::max, std::min, std::sqrt;
    const V zero(0.0f), one(1.0f), two(2.0f);
    const auto dot = [](const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
    const V steepness = dot(g, g), distance = dot(d, d);
    const auto isSurface =
        (steepness > zero) & (steepness <= largest) & (distance > zero) & (distance <= largest);
    const V steep = sqrt(steepness), far = sqrt(distance);
    const V facing = select(dot(g, d) > zero, zero - one, one) / steep;
    const Vec n{select(isSurface, g.x * facing, zero), select(isSurface, g.y * facing, zero),
                select(isSurface, g.z * facing, zero)};
    const Vec v{select(isSurface, (zero - d.x) / far, zero), select(isSurface, (zero - d.y) / far, zero),
                select(isSurface, (zero - d.z) / far, zero)};
    const V above = min(one, max(zero, (steep - V(lighting.weightLow)) * V(lighting.weightScale)));
    const V weight = select(isSurface, above * above * (V(3.0f) - two * above), zero);
    const V towardsViewer = dot(n, v);
    V everywhere[3] = {zero, zero, zero}, facingIt[3] = {zero, zero, zero}, mirrored[3] = {zero, zero, zero};
    for (int i = 0; i < lighting.count; ++i) {
        const LightNumbers& light = lighting.lights[i];
        Vec l = v;
        V shares = one;
        if (light.sort == LightSort::directional) {
            l = {V(light.place[0]), V(light.place[1]), V(light.place[2])};
        } else if (light.sort == LightSort::point) {
            const Vec to = toPoint(light);
            const V squared = min(dot(to, to), largest);
            const V away = sqrt(squared);
            const auto isAway = squared > zero;
            l = {select(isAway, to.x / away, zero), select(isAway, to.y / away, zero),
                 select(isAway, to.z / away, zero)};
            shares = one / (V(light.fading[0]) + V(light.fading[1]) * away + V(light.fading[2]) * squared);
        }
        shares = received.of(i, shares);
        const V slant = dot(n, l);
        const V cosine = min(one, max(zero, slant));
        V sharp = zero;
        if (lighting.halfway) {
            const Vec h{l.x + v.x, l.y + v.y, l.z + v.z};
            const V squared = dot(h, h);
            sharp = select(squared > zero, dot(n, h) / sqrt(squared), zero);
        } else {
            sharp = two * slant * towardsViewer - dot(l, v);
        }
        const V highlight = wholePower(min(one, max(zero, sharp)), m.power);
        const V shine = select(slant > zero, highlight, zero);
        for (int c = 0; c < 3; ++c) {
            const V power = V(light.colour[c]) * shares;
            everywhere[c] = everywhere[c] + power;
            facingIt[c] = facingIt[c] + power * cosine;
            mirrored[c] = mirrored[c] + power * shine;
        }
    }
    const auto scale = [&](int c) {
        const V ambient = received.ambient(m.ambient, c);
        const V volume = ambient + m.diffuse * everywhere[c], surface = ambient + m.diffuse * facingIt[c];
        return volume + weight * (surface - volume);
    };
    const auto add = [&](int c) { return weight * (m.specular * mirrored[c]); };
    return {{scale(0), scale(1), scale(2)}, {add(0), add(1), add(2)}};
}

/// One end of a segment for pre-integration: its place in the table, the bin that holds it, and the bin's
/// entry (extinctionBins()).
template <typename V> struct BinEnd { V place, bin, x, y, z, w; };
/// Extinction, averaged over the values between two ends; exact for the table but for rounding. Zero exactly
/// where every entry around these values is zero.
/// @param low, high  by place
template <typename V> TESSERA_LEAF V meanExtinction(const BinEnd<V>& low, const BinEnd<V>& high) {
    using std::max;
    const V half(0.5f), one(1.0f);
    const V f = low.place - low.bin, g = high.place - high.bin;
    const V inside = low.x + (half * (f + g)) * low.y;
    const V width = high.place - low.place;
    const V above = g * (high.x + (half * g) * high.y);
    const V below = (one - f) * (low.x + (half * (one + f)) * low.y);
    const V beside = below + above; // nothing cancels, however close they are
    const V under = f * (low.x + (half * f) * low.y);
    const V sum = max((high.z - low.z) + ((high.w - low.w) + (above - under)), V(0.0f));
    const V mean = select(low.bin + one == high.bin, beside, sum) / width;
    return select(low.bin == high.bin, inside, mean);
}

/// Mean position that a segment of constant extinction is seen at, over its light, as a share of the way to
/// its back: 1/x - 1/(e^x - 1), x its optical depth.
/// @param terms  1/12, 1/720, 1/30240, 1/1209600, 1/47900160, 691/1307674368000
template <typename V> TESSERA_LEAF V seenDepth(V depth, V alpha, const V (&terms)[6]) {
    const V s = depth * depth;
    const V small =
        V(0.5f) -
        depth * (terms[0] - s * (terms[1] - s * (terms[2] - s * (terms[3] - s * (terms[4] - s * terms[5])))));
    const V large = V(1.0f) / depth - (V(1.0f) - alpha) / alpha;
    return select(depth < V(0.5f), small, large);
}

} // namespace tessera::leaf

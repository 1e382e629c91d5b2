// render/transport/phase.h: phase functions: how a medium scatters light to all sides, by the angle between
// the ways of travel in and out (docs/sampling.md, "Paths"; course notes 7.4.3). All integrate to 1 over the
// sphere, and are sampled exactly.
#pragma once

#include "core/scene/transport.h"

#include <algorithm>
#include <cmath>

namespace tessera {

constexpr float kPi = 3.14159265f;

/// Henyey and Greenstein: (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^(3/2)); its mean cosine is g.
inline float henyeyGreenstein(float g, float cosine) {
    // 1 + g^2 - 2 g cos, exact where it is small
    const float d = g < 0.0f ? (1.0f + g) * (1.0f + g) - 2.0f * g * (1.0f + cosine)
                             : (1.0f - g) * (1.0f - g) + 2.0f * g * (1.0f - cosine);
    return (1.0f - g * g) / (4.0f * kPi * d * std::sqrt(d));
}
/// @param u  uniform
inline float henyeyGreensteinCosine(float g, float u) {
    if (g == 0.0f)
        return 1.0f - 2.0f * u;
    const float s = (1.0f - g * g) / (1.0f - g + 2.0f * g * u);
    return std::clamp((1.0f + g * g - s * s) / (2.0f * g), -1.0f, 1.0f);
}

/// Schlick: (1 - k^2) / (4 pi (1 - k cos)^2), k = 1.55 g - 0.55 g^3: near Henyey and Greenstein's. Below 1:
/// beyond g = 0.94 it is always the same.
inline float schlickNumber(float g) {
    return std::clamp(1.55f * g - 0.55f * g * g * g, -0.999f, 0.999f);
}
inline float schlick(float k, float cosine) {
    const float d = 1.0f - k * cosine;
    return (1.0f - k * k) / (4.0f * kPi * d * d);
}
inline float schlickCosine(float k, float u) {
    return std::clamp((2.0f * u + k - 1.0f) / (2.0f * k * u - k + 1.0f), -1.0f, 1.0f);
}

/// Rayleigh: 3/(16 pi) (1 + cos^2).
inline float rayleigh(float cosine) {
    return 3.0f / (16.0f * kPi) * (1.0f + cosine * cosine);
}
/// Of density 3/8 (1 + c^2): evenly spread with 3/4, else of density 3/2 c^2, which the number of the
/// greatest size among three even ones has.
inline float rayleighCosine(float u, float a, float b, float c) {
    const auto even = [](float v) { return 2.0f * v - 1.0f; };
    if (u < 0.75f)
        return even(a);
    const float x = even(a), y = even(b), z = even(c);
    const float most = std::abs(x) > std::abs(y) ? x : y;
    return std::abs(most) > std::abs(z) ? most : z;
}

/// As it is used: a lobe that is next to even is even.
inline float lobeOf(double g) {
    return std::abs(g) < 1e-3 ? 0.0f : static_cast<float>(g);
}

inline double meanCosine(const Phase& phase) {
    switch (phase.kind) {
    case PhaseKind::schlick: {
        const double k = schlickNumber(lobeOf(phase.g)), k2 = k * k;
        return std::abs(k) < 1e-2 ? 2 * k / 3 : 1 / k - (1 - k2) / (2 * k2) * std::log((1 + k) / (1 - k));
    }
    case PhaseKind::rayleigh:
        return 0;
    case PhaseKind::henyeyGreenstein:
        break;
    }
    return (1 - phase.backShare) * phase.g + phase.backShare * phase.backG;
}

/// The albedo of a medium of which a thick layer reflects such a share of light from all sides to who faces
/// it (docs/sampling.md, "Paths").
/// @param reflectance, meanCosine  [0,1], (-1,1)
inline float albedoOf(float reflectance, float meanCosine) {
    const float r = std::clamp(reflectance, 0.0f, 1.0f), root = (1.0f - r) / (1.0f + 2.0f * r);
    const float lost = root * root;
    return (1.0f - lost) / (1.0f - meanCosine * lost);
}

/// Per steradian.
/// @param cosine  between the ways of travel in and out
inline float phaseOf(const Phase& phase, float cosine) {
    const float g = lobeOf(phase.g), back = lobeOf(phase.backG);
    const auto share = static_cast<float>(phase.backShare);
    switch (phase.kind) {
    case PhaseKind::schlick:
        return schlick(schlickNumber(g), cosine);
    case PhaseKind::rayleigh:
        return rayleigh(cosine);
    case PhaseKind::henyeyGreenstein:
        break;
    }
    const float ahead = henyeyGreenstein(g, cosine);
    return share > 0.0f ? (1.0f - share) * ahead + share * henyeyGreenstein(back, cosine) : ahead;
}

/// A cosine of that density.
/// @param a  uniform: the cosine's place in its distribution, where one number gives that
/// @param next  a further uniform number: f(); three are taken, whatever the kind
template <typename Next> float phaseCosine(const Phase& phase, float a, Next&& next) {
    const float u = next(), b = next(), c = next();
    const float g = lobeOf(phase.g);
    switch (phase.kind) {
    case PhaseKind::schlick:
        return schlickCosine(schlickNumber(g), a);
    case PhaseKind::rayleigh:
        return rayleighCosine(u, a, b, c);
    case PhaseKind::henyeyGreenstein:
        break;
    }
    return henyeyGreensteinCosine(u < static_cast<float>(phase.backShare) ? lobeOf(phase.backG) : g, a);
}

} // namespace tessera

// render/transport/surface_response.h: how a place with a steep gradient answers light, as a surface: evenly
// to its own side and by a lobe to the other, below a thin coat that mirrors (docs/sampling.md, "Paths";
// course notes 7.4.4, 7.5).
#pragma once

#include "render/contract/leaves.h"
#include "render/transport/path_numbers.h"

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

namespace tessera {

/// Unit vectors from the surface; n on the viewer's side.
struct SurfaceResponse {
    float mirrored = 0.028f; // share of light at right angles; that of wet tissue
    float width = 0.1225f;   // of the mirrored lobe: roughness squared
    float translucent = 0;   // share of light below the coat that goes through
    float power = 10;        // exponent of the lobe around the straight way in which it does; 0: evenly

    /// Schlick's approximation of Fresnel's.
    float fresnel(float cosine) const {
        if (!(mirrored > 0.0f))
            return 0.0f;
        const float m = std::clamp(1.0f - cosine, 0.0f, 1.0f), m2 = m * m;
        return mirrored + (1.0f - mirrored) * (m2 * m2 * m);
    }

    /// Of light from l towards v, per steradian and irradiance at right angles to n: by channel. The coat
    /// takes its share on the way in and out, so no light is made, and l and v can be exchanged.
    glm::vec3 of(const glm::vec3& albedo, const glm::vec3& n, const glm::vec3& v, const glm::vec3& l) const {
        const float nv = dot(n, v), nl = dot(n, l);
        if (!(nv > 0.0f) || nl == 0.0f || (nl < 0.0f && !(translucent > 0.0f)))
            return glm::vec3(0.0f);
        const float below = (1.0f - fresnel(nv)) * (1.0f - fresnel(std::abs(nl)));
        if (nl < 0.0f)
            return albedo * (below * translucent * through(v, l));
        const float even = below * 0.318309886f * (1.0f - translucent);
        return albedo * even + glm::vec3(coat(n, v, l, nv, nl));
    }

    /// A direction of light by the response, times its cosine, as good as it can; `share` is response times
    /// cosine over its density. False: no light comes from there.
    /// @param choice, a, b  uniform numbers
    bool sample(const glm::vec3& albedo, const glm::vec3& n, const glm::vec3& v, float choice, float a,
                float b, glm::vec3& l, glm::vec3& share) const {
        const float nv = dot(n, v);
        const float ofCoat = mirrored > 0.0f ? coatChance(nv) : 0.0f;
        const bool goesThrough = choice - ofCoat < translucent * (1.0f - ofCoat);
        if (choice < ofCoat) {
            const float cosine = std::sqrt((1.0f - a) / (1.0f + (width * width - 1.0f) * a));
            const glm::vec3 h = directionAround(n, cosine, b);
            l = 2.0f * dot(v, h) * h - v;
        } else if (goesThrough) {
            l = power > 0.0f ? directionAround(-v, lobeCosine(power, a), b)
                             : directionAround(-n, std::sqrt(1.0f - a), b);
        } else {
            l = directionAround(n, std::sqrt(1.0f - a), b);
        }
        const float nl = dot(n, l);
        const float density = this->density(n, v, l, nv, nl, ofCoat);
        if (!(density > 0.0f) || (choice >= ofCoat && goesThrough) != (nl < 0.0f))
            return false;
        share = of(albedo, n, v, l) * (std::abs(nl) / density);
        return true;
    }

    /// Of the directions that sample() gives, per steradian.
    float density(const glm::vec3& n, const glm::vec3& v, const glm::vec3& l) const {
        const float nv = dot(n, v);
        return density(n, v, l, nv, dot(n, l), mirrored > 0.0f ? coatChance(nv) : 0.0f);
    }

    /// x^power, x up to 1, the same on every processor; 0 from x = 0 down.
    static float powerOf(float x, float power) {
        return x > 0.0f ? 1.0f - leaf::oneMinusExp(power * exponentialOf(1.0f - std::min(x, 1.0f))) : 0.0f;
    }
    /// A cosine c of density (power + 1) c^power, 0 to 1 (course notes 8.4.2).
    /// @param u  uniform
    static float lobeCosine(float power, float u) {
        return 1.0f - leaf::oneMinusExp(exponentialOf(u) / (power + 1.0f));
    }

  private:
    static constexpr float kPerTurn = 0.159154943f; // 1/(2 pi)
    static float dot(const glm::vec3& a, const glm::vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

    /// Light that goes through, where all does. The integral with the cosine is 1 for v along n and for power
    /// 0, which is even; else less.
    float through(const glm::vec3& v, const glm::vec3& l) const {
        return power > 0.0f ? (power + 2.0f) * kPerTurn * powerOf(-dot(v, l), power) : 0.318309886f;
    }
    float throughDensity(const glm::vec3& v, const glm::vec3& l, float nl) const {
        return power > 0.0f ? (power + 1.0f) * kPerTurn * powerOf(-dot(v, l), power) : -nl * 0.318309886f;
    }
    float coatChance(float nv) const { return std::clamp(2.0f * fresnel(nv), 0.1f, 0.9f); }
    /// Normals of the coat's facets, per steradian (Trowbridge and Reitz).
    float facets(float nh) const {
        const float a2 = width * width, d = nh * nh * (a2 - 1.0f) + 1.0f;
        return a2 / (3.14159265f * d * d);
    }
    /// Light that the coat mirrors: facets, those that others hide (Smith), Fresnel.
    float coat(const glm::vec3& n, const glm::vec3& v, const glm::vec3& l, float nv, float nl) const {
        if (!(mirrored > 0.0f))
            return 0.0f;
        const glm::vec3 sum = v + l;
        const float length = std::sqrt(dot(sum, sum));
        if (!(length > 0.0f))
            return 0.0f;
        const glm::vec3 h = sum / length;
        const auto lambda = [&](float cosine) {
            const float c2 = cosine * cosine;
            return 0.5f * (std::sqrt(1.0f + width * width * std::max(0.0f, 1.0f - c2) / c2) - 1.0f);
        };
        const float seen = 1.0f / (1.0f + lambda(nv) + lambda(nl));
        return facets(std::max(0.0f, dot(n, h))) * seen * fresnel(dot(v, h)) / (4.0f * nv * nl);
    }
    float density(const glm::vec3& n, const glm::vec3& v, const glm::vec3& l, float nv, float nl,
                  float ofCoat) const {
        if (!(nv > 0.0f))
            return 0.0f;
        if (!(nl > 0.0f))
            return translucent > 0.0f && nl < 0.0f ? (1.0f - ofCoat) * translucent * throughDensity(v, l, nl)
                                                   : 0.0f;
        float sum = (1.0f - ofCoat) * nl * 0.318309886f * (1.0f - translucent);
        if (ofCoat > 0.0f) {
            glm::vec3 h = v + l;
            h /= std::sqrt(dot(h, h));
            const float nh = std::max(0.0f, dot(n, h)), vh = dot(v, h);
            if (vh > 0.0f)
                sum += ofCoat * facets(nh) * nh / (4.0f * vh);
        }
        return sum;
    }
};

} // namespace tessera

// tests/render/light/reflections_formula_test.cpp: reflections of isosurfaces as docs/sampling.md writes
// them, pixel by pixel: which ways leave a surface, where they begin, and what they bring.
#include "render/light/reflections.h"
#include "tests/support/set_levels.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace tessera::test {
namespace {

constexpr double kAlpha = 0.5; // of every part of a way

glm::dvec3 colourOf(const LightWay& way) {
    const glm::dvec3 middle = way.from + 0.5 * way.voxels * way.direction;
    return {0.5 + 0.3 * std::sin(middle.x), 0.5 + 0.3 * std::sin(0.7 * middle.y + middle.z),
            0.4 + 0.2 * std::cos(way.voxels)};
}

/// docs/sampling.md, "Reflections of isosurfaces", written out once more, for hits of the test's own.
struct Written {
    const FramePlan& p;
    const std::vector<Isosurface>& surfaces; // as the plan has them: by stored values
    double slope;                            // of them
    double steepness;                        // length of the field's gradient, physical units per mm
    int level;
    bool cut; // the box [16,20]^3, voxels, is taken away
    glm::dmat3 toPatient{p.info().patientFromVoxel}, toVoxels{glm::inverse(toPatient)};

    /// What a way brings: parts before and behind the box.
    glm::dvec3 bring(const glm::dvec3& from, const glm::dvec3& mm) const {
        const glm::dvec3 extent(p.info().extentVoxels), d = glm::normalize(toVoxels * mm);
        const auto cross = [&](const glm::dvec3& low, const glm::dvec3& high, double& a, double& b) {
            for (int axis = 0; axis < 3; ++axis) {
                const double t = (low[axis] - from[axis]) / d[axis], u = (high[axis] - from[axis]) / d[axis];
                a = std::max(a, std::min(t, u)), b = std::min(b, std::max(t, u));
            }
            return a < b;
        };
        double a = 0, b = 1e9;
        if (!cross(glm::dvec3(0), extent, a, b))
            return background();
        std::vector<std::pair<double, double>> parts = {{a, b}};
        double c = a, e = b;
        if (cut && cross(glm::dvec3(16), glm::dvec3(20), c, e))
            parts = {{a, c}, {e, b}};
        glm::dvec3 colour(0);
        double left = 1;
        for (const auto& [begin, end] : parts)
            if (end > begin) {
                colour += left * colourOf({from + begin * d, d, end - begin, 1});
                left *= 1 - kAlpha;
            }
        return colour + left * background();
    }
    glm::dvec3 background() const { return glm::dvec3(p.view.background); }

    glm::dvec3 added(const SurfaceHit& hit, const glm::dvec2& place) const {
        const std::size_t number = static_cast<std::size_t>(hit.surface) - 1;
        const Isosurface& surface = surfaces[number];
        const Reflection& r = *surface.reflection;
        const glm::dvec3 n = glm::normalize(glm::dvec3(hit.normal)),
                         d = glm::normalize(toPatient * pixelLine(p.view.frame, place).direction);
        const double c = -glm::dot(d, n);
        // Stored values rise along z: a ray that comes from above leaves, where the slope is above 0.
        const std::size_t lower = slope > 0 ? number - 1 : number + 1; // beyond the list: none
        const double own = r.ior, below = lower < surfaces.size() ? surfaces[lower].reflection->ior : 1;
        const bool enters = slope * (toVoxels * n).z < 0;
        const double n1 = enters ? below : own, n2 = enters ? own : below;
        const double k = 1 - (n1 / n2) * (n1 / n2) * (1 - c * c), ct = std::sqrt(std::max(k, 0.0));
        double f = r.strength;
        if (r.kind == ReflectionKind::fresnel) {
            const double rs = (n1 * c - n2 * ct) / (n1 * c + n2 * ct),
                         rp = (n1 * ct - n2 * c) / (n1 * ct + n2 * c);
            f *= k < 0 ? 1 : (rs * rs + rp * rp) / 2;
        } else if (r.kind == ReflectionKind::gradient) {
            const double t =
                std::clamp((steepness - r.gradient.low) / (r.gradient.high - r.gradient.low), 0.0, 1.0);
            f *= 3 * t * t - 2 * t * t * t;
        }
        const double w = static_cast<double>(hit.weight);
        const glm::dvec3 along = toVoxels * n;
        const double pitchMm =
            std::ldexp(1.0, level) / std::max({std::abs(along.x), std::abs(along.y), std::abs(along.z)});
        const auto brought = [&](double factor, const glm::dvec3& to) {
            if (factor < 1.0 / 255)
                return glm::dvec3(0);
            const glm::dvec3 from = glm::dvec3(hit.position) +
                                    toVoxels * to * (pitchMm / std::max(std::abs(glm::dot(to, n)), 0.25));
            return factor * bring(from, to);
        };
        const glm::dvec3 mirrored = d + 2 * c * n;
        if (!surface.transmits())
            return brought(w * surface.opacity * f, mirrored);
        if (k < 0)
            return brought(w, mirrored);
        const glm::dvec3 bent = n1 / n2 * d + (n1 / n2 * c - ct) * n;
        return brought(w * f, mirrored) + brought(w * (1 - f) * (1 - surface.opacity), glm::normalize(bent));
    }
};

TEST(Reflections, AreTheirFormula) {
    for (const double slope : {2.0, -2.0}) {
        const Stored stored([](const glm::dvec3& p) { return 0.1 * p.z - 2; }, glm::ivec3(44, 40, 48), false,
                            slope);
        for (const int level : {0, 1, 2}) // 2: of level 1, but of the finest samples
            for (const bool cut : {false, true}) {
                const bool finest = level == 2;
                std::vector<Isosurface> surfaces(3);
                surfaces[0] = {-1, {0.9, 0.6, 0.5}, 0.7};
                surfaces[0].reflection = Reflection{
                    .kind = ReflectionKind::gradient, .strength = 0.9, .gradient = {0.05, 0.3}, .ior = 1.2};
                surfaces[1] = {0, {0.9, 0.6, 0.5}, 0.3};
                surfaces[1].reflection = Reflection{
                    .kind = ReflectionKind::fresnel, .strength = 0.8, .ior = 1.7, .transmits = true};
                surfaces[2] = {0.5, {0.3, 0.9, 0.4}, 0.6};
                surfaces[2].reflection = Reflection{.strength = 0.5, .ior = 1.1};
                Scene scene = stored.scene(surfaces);
                scene.imageSize = {13, 9};
                scene.background = glm::vec3(0.2f, 0.5f, 0.9f);
                scene.lighting.reflectionOrder = 1;
                if (cut)
                    scene.cuts.boxes = {{{16, 16, 16}, {20, 20, 20}, CropBox::Space::voxels, Keep::outside}};
                const auto prepared = stored.prepare(scene);
                Planner& p = prepared->p;
                setLevels(p, std::min(level, 1));
                const glm::dmat3 toPatient(p.info().patientFromVoxel);
                const double steepness =
                    glm::length(glm::transpose(glm::inverse(toPatient)) * glm::dvec3(0, 0, 0.1 * slope));
                EXPECT_GT(steepness, 0.1);
                EXPECT_LT(steepness, 0.25);
                if (slope < 0)
                    std::reverse(surfaces.begin(), surfaces.end());
                const Written written{p, surfaces, slope, steepness, finest ? 0 : level, cut};
                std::mt19937 random(3);
                std::uniform_real_distribution<double> unit(-1, 1);
                std::vector<SurfaceHit> hits(13 * 9);
                std::vector<glm::vec2> places;
                for (std::size_t n = 0; n < hits.size(); ++n) {
                    SurfaceHit& hit = hits[n];
                    places.emplace_back(static_cast<float>(n % 13) + 0.4f, static_cast<float>(n / 13) + 0.7f);
                    const glm::dvec3 d =
                        glm::normalize(toPatient * pixelLine(p.view.frame, glm::dvec2(places[n])).direction);
                    glm::dvec3 normal(unit(random), unit(random), unit(random));
                    normal = glm::normalize(normal - 1.2 * d);
                    if (glm::dot(normal, d) > 0)
                        normal = -normal;
                    hit.normal = n % 17 == 5 ? glm::vec3(0) : glm::vec3(normal);
                    hit.surface = static_cast<int>(n % 4);
                    hit.weight = static_cast<float>(0.6 + 0.4 * unit(random));
                    hit.position =
                        glm::vec3(22 + 4 * unit(random), 20 + 4 * unit(random), 21 + 4 * unit(random));
                }
                const Reflections reflections(p, 2, finest);
                const Image added = reflections.added(
                    hits, places, {13, 9},
                    [](std::span<const LightWay> ways, std::span<glm::vec4> colours, std::span<SurfaceHit>) {
                        for (std::size_t n = 0; n < ways.size(); ++n)
                            colours[n] = glm::vec4(glm::vec3(colourOf(ways[n])), static_cast<float>(kAlpha));
                    });
                std::size_t compared = 0;
                for (std::size_t n = 0; n < hits.size(); ++n) {
                    const glm::vec4& found = added.pixels[n];
                    if (hits[n].surface == 0 || hits[n].normal == glm::vec3(0)) {
                        EXPECT_EQ(found, glm::vec4(0));
                        continue;
                    }
                    const glm::dvec3 truth = written.added(hits[n], glm::dvec2(places[n]));
                    EXPECT_LT(glm::distance(glm::dvec3(found), truth), 2e-4)
                        << n << " of surface " << hits[n].surface;
                    EXPECT_EQ(found.a, 0);
                    compared += glm::length(truth) > 0.02;
                }
                EXPECT_GT(compared, 60u);
            }
    }
}

/// What a cut leaves of a way before a mirror takes light from that mirror, as the volume in its own part
/// does.
TEST(Reflections, WhatLiesBeforeAMirrorDimsIt) {
    const Stored stored([](const glm::dvec3& p) { return 0.1 * p.z - 2; }, glm::ivec3(40), true);
    Isosurface mirror{0, {0.9, 0.6, 0.5}, 0.6};
    mirror.reflection = Reflection{.strength = 0.5};
    Scene scene = stored.scene({mirror});
    scene.imageSize = {1, 1};
    Camera above;
    above.position = {20, 20, 60};
    above.focalPoint = {20, 20, 10};
    above.viewUp = {0, 1, 0};
    scene.camera = above;
    scene.background = glm::vec3(0.0f);
    scene.cuts.boxes = {{{0, 0, 20}, {40, 40, 24}, CropBox::Space::voxels, Keep::outside}};
    const auto prepared = stored.prepare(scene);
    SurfaceHit hit{{20, 20, 10}, 1, {0, 0, 1}, 1};
    const glm::vec2 place(0.5f);
    const auto addedBy = [&](int orders) {
        prepared->p.view.lighting.reflectionOrder = orders;
        int calls = 0;
        const Reflections reflections(prepared->p, 1);
        const Image image = reflections.added(
            std::span(&hit, 1), std::span(&place, 1), {1, 1},
            [&](std::span<const LightWay> ways, std::span<glm::vec4> colours, std::span<SurfaceHit> hits) {
                if (++calls == 1) {
                    ASSERT_EQ(ways.size(), 2u);
                    colours[0] = colours[1] = {1, 1, 1, 0.5f};
                    hits[1] = {{20, 20, 30}, 0.8f, {0, 0, -1}, 1};
                } else {
                    std::fill(colours.begin(), colours.end(), glm::vec4(0, 0, 0, 1));
                    colours[0] = glm::vec4(1);
                }
            });
        EXPECT_EQ(calls, orders);
        return static_cast<double>(image.pixels[0].g);
    };
    // Half of 0.6 of what the way sees, which meets the mirror again behind half of the light and 0.8.
    EXPECT_NEAR(addedBy(1), 0.3 * (1 + 0.5), 1e-6);
    EXPECT_NEAR(addedBy(2), 0.3 * (1 + 0.5 + 0.5 * 0.8 * 0.3), 1e-6);
}

} // namespace
} // namespace tessera::test

// tests/render/light/surface_formula_test.cpp: occlusion of isosurfaces as docs/sampling.md writes it, pixel
// by pixel: rays, places that share, and what is added.
#include "render/light/surface_light.h"
#include "tests/support/set_levels.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <span>
#include <vector>

namespace tessera::test {
namespace {

/// Takes light by a formula of the way, and remembers none.
struct FormulaTracer : SurfaceTracer {
    static LightTaken of(const LightWay& way) {
        const double part = 0.5 + 0.4 * std::sin(1.3 * way.from.x + 0.7 * way.from.y - 0.4 * way.from.z +
                                                 5 * way.direction.x - 3 * way.direction.z);
        return {static_cast<float>(part), static_cast<float>(part * 0.4 * way.voxels * way.mmPerVoxel)};
    }
    void trace(std::span<const LightWay> ways, std::span<LightTaken> taken) const override {
        std::transform(ways.begin(), ways.end(), taken.begin(), of);
    }
};

/// docs/sampling.md, "Occlusion of isosurfaces", written out once more, with hits and surfaces of the test's
/// own.
TEST(SurfaceLight, IsItsFormula) {
    const Stored stored([](const glm::dvec3& p) { return 0.1 * p.z - 2; });
    for (const int level : {0, 1}) {
        const double radius = 12;
        constexpr int kRays = 8;
        Scene scene = stored.scene({{0, {0.9, 0.6, 0.5}, 0.7}, {0.5, {0.3, 0.9, 0.4}, 1}});
        scene.imageSize = {13, 9};
        scene.shading.ambient = 0.8;
        scene.lighting.surfaceOcclusion = SurfaceOcclusion{kRays, radius, true};
        scene.quality.pixels.seed = 5;
        const auto prepared = stored.prepare(scene);
        Planner& p = prepared->p;
        setLevels(p, level);
        const glm::dmat3 toPatient(p.info().patientFromVoxel), toVoxels = glm::inverse(toPatient);
        const glm::dvec3 extent(p.info().extentVoxels);
        // Around a place in the middle, half a millimetre apart; some pixels have none, or no normal.
        std::mt19937 random(3);
        std::uniform_real_distribution<double> unit(-1, 1);
        std::vector<SurfaceHit> hits(13 * 9);
        for (int y = 0; y < 9; ++y)
            for (int x = 0; x < 13; ++x) {
                SurfaceHit& hit = hits[static_cast<std::size_t>(y * 13 + x)];
                hit.surface = (x + 2 * y) % 11 == 3 ? 0 : x < 8 ? 1 : 2;
                hit.weight = static_cast<float>(0.6 + 0.4 * unit(random));
                const glm::dvec3 mm(0.4 * (x - 6), 0.5 * (y - 4), 0.05 * unit(random));
                hit.position = glm::vec3(glm::dvec3(22, 20, 21) + toVoxels * mm);
                if ((x * y) % 17 != 5)
                    hit.normal =
                        glm::vec3(glm::normalize(glm::dvec3(0.2 * unit(random), 0.2 * unit(random), 1)));
            }
        const auto around = [&](const SurfaceHit& hit, const glm::vec2& place) {
            const glm::dvec3 normal(hit.normal), above = toVoxels * normal;
            const double most = std::max({std::abs(above.x), std::abs(above.y), std::abs(above.z)});
            double open = 0;
            for (const glm::dvec3& d : hemisphereDirections(normal, kRays, hemisphereKey(place, 5))) {
                LightWay way;
                way.from = glm::dvec3(hit.position) + std::ldexp(1.0, level) / most * above;
                way.mmPerVoxel = 1 / glm::length(toVoxels * d);
                way.direction = glm::normalize(toVoxels * d);
                way.voxels = radius / way.mmPerVoxel;
                for (int axis = 0; axis < 3; ++axis)
                    if (way.direction[axis] != 0)
                        way.voxels = std::min(
                            way.voxels, ((way.direction[axis] > 0 ? extent[axis] : 0) - way.from[axis]) /
                                            way.direction[axis]);
                const LightTaken taken = FormulaTracer::of(way);
                open += (1 - (double{taken.taken} - double{taken.mm} / radius)) / kRays;
            }
            return std::clamp(open, 0.0, 1.0);
        };
        const auto centre = [](int x, int y) {
            return glm::vec2(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
        };
        const FormulaTracer tracer;
        SurfaceLight light(p, 2);
        light.look(hits, tracer);
        std::vector<double> open;
        std::size_t places = 0;
        for (int y = 0; y < 9; ++y)
            for (int x = 0; x < 13; ++x) {
                const SurfaceHit& hit = hits[open.size()];
                const bool counts = hit.surface != 0 && hit.normal != glm::vec3(0);
                open.push_back(counts ? around(hit, centre(x, y)) : 1);
                places += counts;
                ASSERT_NEAR(light.open()[open.size() - 1], open.back(), 1e-4) << x << "," << y;
            }
        EXPECT_EQ(light.report().places, places);
        EXPECT_EQ(light.report().rays, kRays);
        EXPECT_EQ(light.report().radiusMm, radius);
        // Middles, and places beside them.
        std::vector<glm::vec2> beside;
        std::vector<SurfaceHit> between = hits;
        for (int y = 0; y < 9; ++y)
            for (int x = 0; x < 13; ++x) {
                beside.push_back(centre(x, y) + glm::vec2(0.3f, -0.2f));
                between[beside.size() - 1].position += glm::vec3(toVoxels * glm::dvec3(0.1, -0.1, 0));
            }
        const double reach = radius / 4, flat = reach / 4, apart = 0.8 / std::pow(kRays, 0.75);
        for (const bool isBeside : {false, true}) {
            const std::vector<SurfaceHit>& own = isBeside ? between : hits;
            const Image added = light.added(
                own, {}, isBeside ? std::span<const glm::vec2>(beside) : std::span<const glm::vec2>(),
                {13, 9}, tracer);
            std::size_t shared = 0;
            for (int y = 0; y < 9; ++y)
                for (int x = 0; x < 13; ++x) {
                    const std::size_t i = static_cast<std::size_t>(y * 13 + x);
                    const SurfaceHit& hit = own[i];
                    if (hit.surface == 0 || hit.normal == glm::vec3(0)) {
                        ASSERT_EQ(added.pixels[i], glm::vec4(0));
                        continue;
                    }
                    const auto weightOf = [&](std::size_t n) {
                        const SurfaceHit& other = hits[n];
                        const glm::dvec3 off = toPatient * glm::dvec3(other.position - hit.position);
                        const double near = 1 - glm::dot(off, off) / (reach * reach),
                                     level = 1 - std::pow(glm::dot(glm::dvec3(hit.normal), off) / flat, 2),
                                     facing = glm::dot(glm::dvec3(hit.normal), glm::dvec3(other.normal));
                        return other.surface != hit.surface || near <= 0 || level <= 0 || facing <= 0
                                   ? 0
                                   : near * near * level * level * std::pow(facing, 8);
                    };
                    double sum = 0, weights = 0;
                    for (int v = std::max(0, y - 3); v <= std::min(8, y + 3); ++v)
                        for (int u = std::max(0, x - 3); u <= std::min(12, x + 3); ++u) {
                            const std::size_t n = static_cast<std::size_t>(v * 13 + u);
                            const double off = (open[n] - open[i]) / apart;
                            const double alike = weightOf(i) > 0 ? std::max(0.0, 1 - off * off) : 1;
                            sum += weightOf(n) * alike * alike * open[n];
                            weights += weightOf(n) * alike * alike;
                        }
                    ASSERT_GT(std::abs(weights - 1.0 / 64), 1e-6);
                    shared += weights > 1.0 / 64;
                    const double expected =
                        weights > 1.0 / 64 ? sum / weights : around(hit, isBeside ? beside[i] : centre(x, y));
                    const glm::dvec3 colour =
                        hit.surface == 1 ? 0.7 * glm::dvec3(0.9, 0.6, 0.5) : glm::dvec3(0.3, 0.9, 0.4);
                    for (int c = 0; c < 3; ++c)
                        ASSERT_NEAR(added.pixels[i][c], double{hit.weight} * colour[c] * 0.8 * (expected - 1),
                                    2e-4)
                            << level << (isBeside ? ", beside " : ", ") << x << "," << y;
                    ASSERT_EQ(added.pixels[i].a, 0);
                }
            EXPECT_GT(shared, 60u);
        }
    }
}

} // namespace
} // namespace tessera::test

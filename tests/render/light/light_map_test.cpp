// tests/render/light/light_map_test.cpp: light maps of closed forms: tissue that scatters nothing, slabs that
// take nothing, a thin beam; slices of rays; look-ups; threads.
#include "render/light/light_map.h"
#include "render/light/light_sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <vector>

namespace tessera::test {
namespace {

LightGrid gridOf(int size, int slices, double sliceMm = 1, double rayMm = 1) {
    LightGrid grid;
    grid.size = size;
    grid.slices = slices;
    grid.sliceMm = sliceMm;
    grid.rayMm = rayMm;
    return grid;
}

/// All rays alike: a slab of such a depth in all.
struct Slab {
    Slab(const LightGrid& grid, double g, double depth, double albedo, int threads = 1)
        : sweep(grid, g), map(grid) {
        const std::vector<LightSlice> slices(
            static_cast<std::size_t>(grid.slices),
            {static_cast<float>(depth / grid.slices), glm::vec3(static_cast<float>(albedo))});
        for (int y = 0; y < grid.size; ++y)
            for (int x = 0; x < grid.size; ++x)
                sweep.setRay({x, y}, slices);
        sweep.run(threads, map);
    }
    MapSweep sweep;
    LightMap map;
};

/// No light leaves these sideways: as of one of six views.
LightGrid closed(LightGrid grid) {
    grid.oneOfSides = true;
    return grid;
}

/// Random tissue, that scatters no light.
TEST(LightMap, IsTheShadowOfTissueThatScattersNothing) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> depths(0, 0.4f);
    const LightGrid grid = gridOf(5, 9);
    MapSweep sweep(grid, 0.8);
    LightMap map(grid);
    std::vector<std::vector<float>> rays;
    std::vector<LightSlice> slices(9);
    for (int n = 0; n < 25; ++n) {
        rays.emplace_back();
        for (LightSlice& slice : slices)
            rays.back().push_back(slice.depth = depths(random));
        sweep.setRay({n % 5, n / 5}, slices);
    }
    sweep.run(1, map);
    for (std::size_t n = 0; n < 25; ++n) {
        double depth = 0;
        for (std::size_t plane = 0; plane <= 9; ++plane) {
            const std::size_t node = plane * 25 + n;
            EXPECT_NEAR(double{sweep.beam(node)}, std::exp(-depth), 1e-4);
            for (int c = 0; c < 3; ++c)
                EXPECT_EQ(map.node(node)[c], 0);
            depth += plane < 9 ? double{rays[n][plane]} : 0;
        }
    }
}

TEST(LightMap, LosesNothingInASlabThatTakesNothing) {
    for (const double g : {0.0, 0.8})
        for (const double depth : {0.3, 1.0, 4.0, 16.0, 40.0}) {
            double before = 0;
            for (const int slices : {2, 12}) {
                const Slab slab(closed(gridOf(12, slices)), g, depth, 1);
                EXPECT_NEAR(slab.sweep.ahead().r + slab.sweep.back().r, 1, 0.02) << g << ", " << depth;
                if (slices > 2) {
                    EXPECT_NEAR(slab.sweep.back().r, before, 0.005) << "whatever the slices' thickness";
                }
                before = slab.sweep.back().r;
            }
        }
}

/// Nor much in blocks of tissue and air, where light spreads from one to the other.
TEST(LightMap, LosesLittleInUnevenTissue) {
    for (const double g : {0.0, 0.8})
        for (const float most : {0.2f, 1.0f, 3.0f})
            for (const int edge : {1, 4, 8}) {
                std::mt19937 random(5);
                std::uniform_real_distribution<float> any(0, 1);
                std::vector<float> blocks(32 * 32 * 32);
                for (float& block : blocks)
                    block = any(random) < 0.5f ? 0 : most * any(random);
                const LightGrid grid = closed(gridOf(32, 32));
                MapSweep sweep(grid, g);
                LightMap map(grid);
                std::vector<LightSlice> slices(32);
                for (int y = 0; y < 32; ++y)
                    for (int x = 0; x < 32; ++x) {
                        for (int k = 0; k < 32; ++k)
                            slices[static_cast<std::size_t>(k)] = {
                                blocks[static_cast<std::size_t>(k / edge * 1024 + y / edge * 32 + x / edge)],
                                glm::vec3(1)};
                        sweep.setRay({x, y}, slices);
                    }
                sweep.run(1, map);
                EXPECT_NEAR(sweep.ahead().r + sweep.back().r, 1, 0.06) << g << ", " << most << ", " << edge;
                EXPECT_GT(sweep.back().r, 0.1);
            }
}

/// The mean of what is scattered to planes of a slab, over the light that falls on it, by paths.
std::vector<double> fluenceByPaths(double g, double depth, double albedo, int planes, int paths) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> share(0, 1);
    std::vector<double> sum(static_cast<std::size_t>(planes) + 1);
    for (int n = 0; n < paths; ++n) {
        double z = 0, cosine = 1, weight = 1;
        for (bool scattered = false; z >= 0 && z <= depth && weight > 1e-4; scattered = true) {
            const double next = z - std::log(1 - share(random)) * cosine;
            for (int k = 0; scattered && k <= planes; ++k)
                if (const double at = depth * k / planes; std::min(z, next) < at && at <= std::max(z, next))
                    sum[static_cast<std::size_t>(k)] += weight / std::max(0.01, std::abs(cosine)) / paths;
            z = next;
            weight *= albedo;
            const double u = share(random), q = (1 - g * g) / (1 - g + 2 * g * u);
            const double turn = g > 0 ? (1 + g * g - q * q) / (2 * g) : 2 * u - 1;
            cosine = cosine * turn + std::sqrt((1 - cosine * cosine) * (1 - turn * turn)) *
                                         std::cos(2 * std::numbers::pi * share(random));
            cosine = std::clamp(cosine, -1.0, 1.0);
        }
    }
    return sum;
}

/// Two streams, and not a beam alone: within a sixth of the brightest place, inside a slab of any kind.
TEST(LightMap, IsAsBrightAsPathsInASlab) {
    for (const double g : {0.0, 0.8})
        for (const double albedo : {0.7, 0.95})
            for (const double depth : {1.0, 5.0}) {
                const Slab slab(closed(gridOf(8, 8)), g, depth, albedo);
                const std::vector<double> paths = fluenceByPaths(g, depth, albedo, 8, 20000);
                const double most = *std::max_element(paths.begin(), paths.end());
                for (int k = 1; k < 8; ++k)
                    EXPECT_NEAR(double{slab.map.at({4, 4}, static_cast<float>(k)).g},
                                paths[static_cast<std::size_t>(k)], g > 0 ? most / 6 : most * 0.45)
                        << g << ", " << albedo << ", " << depth << ", plane " << k;
            }
}

/// A slice is what its halves are, one behind the other, at any depth; where the solution changes its form,
/// too.
TEST(LightMap, LayersAreThoseOfTheirHalves) {
    for (const double g : {0.0, 0.5, 0.9})
        for (const float albedo : {0.0f, 0.3f, 0.7f, 0.95f, 1.0f})
            for (const float depth : {1e-4f, 1.5e-3f, 0.02f, 0.5f, 3.0f, 12.0f}) {
                const SweptScattering scattering(g);
                const SweptLayer half = sweptLayer(depth / 2, -std::expm1(-depth / 2), albedo, scattering),
                                 whole = sweptLayer(depth, -std::expm1(-depth), albedo, scattering);
                const double t = half.through, r = half.returned, often = 1 / (1 - r * r);
                const double beam = std::exp(-double{depth} / 2);
                EXPECT_NEAR(whole.through, t * t * often, 2e-3);
                EXPECT_NEAR(whole.returned, r + t * t * r * often, 2e-3);
                const double onwards = (half.sent + r * half.sentBack * beam) * often; // between the halves
                EXPECT_NEAR(whole.sent, t * onwards + half.sent * beam, 3e-3) << g << albedo << depth;
                EXPECT_NEAR(whole.sentBack,
                            half.sentBack + t * (half.sentBack * beam + r * half.sent) * often, 3e-3);
                EXPECT_LE(whole.through + whole.returned, 1.0001f);
                EXPECT_LE(whole.sent + whole.sentBack + std::exp(-depth), 1.0001f);
            }
}

/// P_f is an integral of the phase function over half of the sphere.
TEST(LightMap, SendsOnwardsWhatThePhaseFunctionSays) {
    for (const double g : {0.0, 0.3, 0.8, 0.95}) {
        double onwards = 0, mean = 0;
        constexpr int kParts = 200000;
        for (int n = 0; n < kParts; ++n) {
            const double cosine = -1 + (n + 0.5) * 2 / kParts;
            const double phase = 0.5 * (1 - g * g) / std::pow(1 + g * g - 2 * g * cosine, 1.5) * 2 / kParts;
            onwards += cosine > 0 ? phase : 0;
            mean += cosine * phase;
        }
        const SweptScattering scattering(g);
        EXPECT_NEAR(double{scattering.onwards}, onwards, 1e-4);
        EXPECT_NEAR(double{scattering.back}, 1 - onwards, 1e-4);
        EXPECT_NEAR(double{scattering.turned}, (1 - mean) / 2, 1e-4);
    }
}

/// Of a thin beam in tissue that takes nothing, behind a sheet with a hole: the mean square of the distance
/// from its axis at the far side, mm^2.
double spotOf(int slices, double mm, double depth, double g) {
    constexpr int kSize = 41, kMiddle = 20;
    // A slice of its own before the tissue: the sheet.
    const double sliceMm = mm / slices;
    const double rayMm = mm / 12;
    const LightGrid grid = gridOf(kSize, slices + 1, sliceMm, rayMm);
    MapSweep sweep(grid, g);
    LightMap map(grid);
    std::vector<LightSlice> tissue(static_cast<std::size_t>(slices + 1),
                                   {static_cast<float>(depth / slices), glm::vec3(1)});
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            tissue[0] = {x == kMiddle && y == kMiddle ? 0.0f : kOpaqueDepth, glm::vec3(0)};
            sweep.setRay({x, y}, tissue);
        }
    sweep.run(1, map);
    double sum = 0, square = 0;
    const std::size_t last = grid.nodes() - grid.nodesOfPlane();
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const std::size_t n = last + static_cast<std::size_t>(y * kSize + x);
            const double light =
                double{sweep.beam(n)} + double(map.node(n)[0]) / 16384 / double{SweptScattering::kObliquity};
            sum += light;
            square += light * rayMm * rayMm * ((x - kMiddle) * (x - kMiddle) + (y - kMiddle) * (y - kMiddle));
        }
    return square / sum;
}

/// z^3 tau <theta^2> / 3, tau per mm, whatever the thickness of slices.
TEST(LightMap, SpreadsAThinBeamByItsMoments) {
    for (const double mm : {12.0, 24.0})
        for (const double depth : {0.3, 1.0}) {
            const double formula = mm * mm * depth * 2 * (1 - 0.9) / 3;
            double before = 0;
            for (const int slices : {12, 24, 48}) {
                const double found = spotOf(slices, mm, depth, 0.9);
                EXPECT_NEAR(found, formula, 0.1 * formula) << mm << ", " << depth << ", " << slices;
                if (before > 0) {
                    EXPECT_NEAR(found, before, 0.02 * before);
                }
                before = found;
            }
        }
}

/// Tissue of random depths and colours.
LightMap randomMap(const LightGrid& grid, int threads) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> any(0, 1);
    MapSweep sweep(grid, 0.6);
    LightMap map(grid);
    std::vector<LightSlice> slices(static_cast<std::size_t>(grid.slices));
    for (int y = 0; y < grid.size; ++y)
        for (int x = 0; x < grid.size; ++x) {
            for (LightSlice& slice : slices)
                slice = {any(random) < 0.5f ? 0.0f : any(random), {any(random), any(random), any(random)}};
            sweep.setRay({x, y}, slices);
        }
    sweep.run(threads, map);
    return map;
}

TEST(LightMap, HasTheSameBitsForAnyNumberOfThreads) {
    const LightGrid grid = gridOf(37, 20);
    const LightMap one = randomMap(grid, 1);
    for (const int threads : {2, 3, 5}) {
        const LightMap other = randomMap(grid, threads);
        for (std::size_t n = 0; n < grid.nodes(); ++n)
            for (int c = 0; c < 3; ++c)
                ASSERT_EQ(other.node(n)[c], one.node(n)[c]) << threads << ", " << n;
    }
}

TEST(LightMap, IsInterpolatedBetweenNodes) {
    LightGrid grid = gridOf(4, 3, 2, 1);
    grid.nearMm = 10;
    LightMap map(grid);
    const auto light = [](double x, double y, double z) { return 0.1 * x + 0.2 * y + 0.3 * z; };
    for (int z = 0; z <= 3; ++z)
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 4; ++x)
                for (int c = 0; c < 3; ++c)
                    map.node(static_cast<std::size_t>(16 * z + 4 * y + x))[c] =
                        static_cast<std::uint16_t>(16384 * light(x, y, z) / (c + 1));
    const auto expect = [&](double x, double y, double z, double expected) {
        const glm::vec3 found = map.at(glm::vec2(x + 0.5, y + 0.5), static_cast<float>(10 + 2 * z));
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(double{found[c]}, expected / (c + 1), 1e-3) << x << ", " << y << ", " << z;
    };
    for (const double x : {0.0, 0.3, 1.5, 3.0})
        for (const double y : {0.0, 1.9, 3.0})
            for (const double z : {0.0, 0.75, 2.5, 3.0})
                expect(x, y, z, light(x, y, z));
    expect(1, 2, -4, light(1, 2, 0));
    expect(1, 2, 9, light(1, 2, 3));
    expect(-0.4, 2, 1, light(0, 2, 1));
    expect(-0.6, 2, 1, light(0, 2, 1));
    expect(1, 3.6, 1, light(1, 3, 1));
    grid.oneOfSides = true;
    LightMap side(grid);
    std::copy_n(map.node(0), 3 * grid.nodes(), side.node(0));
    EXPECT_NEAR(double{side.at({-3, 2.5f}, 12).r}, light(0, 2, 1), 1e-3);
}

TEST(LightMap, SlicesHoldTheDepthOfARay) {
    LightGrid grid = gridOf(1, 4, 2, 2);
    grid.nearMm = 1; // slices from 1, 3, 5 and 7 mm on
    std::vector<LightSlice> slices(4);
    addToSlices(grid, 2, 6, 4, {1, 0.5f, 0}, slices);
    addToSlices(grid, 2, 3, 3, {0, 0.5f, 1}, slices);
    addToSlices(grid, 8.5f, 8.5f, 7, {0, 0, 0}, slices); // a surface
    finishSlices(grid, -1, slices);
    const float depths[] = {4, 2, 1, 7};
    for (std::size_t n = 0; n < 4; ++n)
        EXPECT_NEAR(slices[n].depth, depths[n], 1e-5f) << n;
    EXPECT_NEAR(slices[0].albedo.r, 0.25f, 1e-6f);
    EXPECT_NEAR(slices[0].albedo.g, 0.5f, 1e-6f);
    EXPECT_NEAR(slices[0].albedo.b, 0.75f, 1e-6f);
    EXPECT_NEAR(slices[2].albedo.r, 1, 1e-6f);
    EXPECT_EQ(slices[3].albedo, glm::vec3(0));
    // A ray that ended in the dark, at 5.5 mm: what is behind is as the last whole slice.
    std::vector<LightSlice> dark(4);
    addToSlices(grid, 1, 5.5f, 9, {0.5f, 0.5f, 0.5f}, dark);
    finishSlices(grid, 5.5f, dark);
    for (const LightSlice& slice : dark)
        EXPECT_NEAR(slice.depth, 4, 1e-5f);
    // What is opaque stays so behind haze.
    std::vector<LightSlice> wall(4);
    addToSlices(grid, 1, 3, 0.01f, {1, 1, 1}, wall);
    addToSlices(grid, 3, 4, 70, {0.5f, 0.5f, 0.5f}, wall);
    finishSlices(grid, 4, wall);
    const float walls[] = {0.01f, 70, 70, 70};
    for (std::size_t n = 0; n < 4; ++n)
        EXPECT_NEAR(wall[n].depth, walls[n], 1e-4f) << n;
}

TEST(LightMap, BytesAreThoseOfItsNumbers) {
    for (const int size : {1, 16, 96}) {
        EXPECT_EQ(LightMap::bytes(size), LightMap(gridOf(size, size)).bytes());
        const auto nodes = static_cast<std::size_t>(size * size * (size + 1));
        EXPECT_EQ(LightMap::bytes(size), nodes * 6);
        EXPECT_GE(MapSweep::bytes(size), nodes * 15);
    }
    // A slice is as thick as rays are apart, or there are as many as rays.
    const LightGrid thin = LightGrid::between(10, 60, 2, 96, false),
                    thick = LightGrid::between(0, 900, 2, 96, false);
    EXPECT_EQ(thin.slices, 25);
    EXPECT_EQ(thin.sliceMm, 2);
    EXPECT_EQ(thick.slices, 96);
    EXPECT_EQ(LightGrid::between(100, 300, 0.02, 96, true).slices, 50) << "4 mm in the middle";
}

} // namespace
} // namespace tessera::test

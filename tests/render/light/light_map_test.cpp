// tests/render/light/light_map_test.cpp: light maps of closed forms: tissue that scatters nothing, slabs that take
// nothing, a thin beam; slices of rays; look-ups; threads.
#include "render/light/light_map.h"
#include "render/light/light_sweep.h"
#include "tests/support/reference_light.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <gtest/gtest.h>
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
    LightSweep sweep;
    LightMap map;
};

/// No light leaves these sideways: as of one of six views.
LightGrid closed(LightGrid grid) {
    grid.oneOfSides = true;
    return grid;
}

TEST(LightMap, LosesNothingInASlabThatTakesNothing) {
    for (const double g : {0.0, 0.8})
        for (const double depth : {0.3, 1.0, 4.0, 16.0, 40.0})
            for (const int slices : {2, 12}) {
                const Slab slab(closed(gridOf(12, slices)), g, depth, 1);
                const double all = slab.sweep.ahead().r + slab.sweep.back().r;
                EXPECT_NEAR(all, 1, 0.02) << g << ", " << depth << ", " << slices;
                tell("g %g, depth %g, %d slices: ahead %.4f, back %.4f\n", g, depth, slices, slab.sweep.ahead().r, slab.sweep.back().r);
            }
}

TEST(LightMap, Profiles) {
    for (const double g : {0.0, 0.8, 0.95})
        for (const double c : {1.0, 0.9, 0.7})
            for (const double depth : {1.0, 4.0, 16.0}) {
                const Slab slab(closed(gridOf(8, 8)), g, depth, c);
                tell("g %.2f c %.2f L %g:", g, c, depth);
                for (int k = 0; k <= 8; ++k)
                    tell(" %.3f", double(slab.map.at({4, 4}, float(k)).r));
                tell("  T %.3f R %.3f\n", slab.sweep.ahead().r, slab.sweep.back().r);
            }
}

/// Of a thin beam in tissue that takes nothing, behind a sheet with a hole: the mean square of the distance from
/// its axis at the far side, mm^2.
double spotOf(int slices, double mm, double depth, double g) {
    constexpr int kSize = 41, kMiddle = 20;
    // A slice of its own before the tissue: the sheet.
    const double sliceMm = mm / slices;
    const double rayMm = mm / 12;
    const LightGrid grid = gridOf(kSize, slices + 1, sliceMm, rayMm);
    LightSweep sweep(grid, g);
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
            const double light = double{sweep.beam(n)} + double(map.node(n)[0]) / 16384 /
                                                             double{SweptScattering::kObliquity};
            sum += light;
            square += light * rayMm * rayMm *
                      ((x - kMiddle) * (x - kMiddle) + (y - kMiddle) * (y - kMiddle));
        }
    return square / sum;
}

TEST(LightMap, SpreadsAThinBeamByItsMoments) {
    for (const double mm : {12.0, 24.0})
        for (const double depth : {0.3, 1.0})
            for (const int slices : {12, 24, 48}) {
                const double formula = mm * mm * depth * 2 * (1 - 0.9) / 3, found = spotOf(slices, mm, depth, 0.9);
                tell("%g mm, depth %g, %d slices: %.3f, formula %.3f, ratio %.3f\n", mm, depth, slices, found, formula, found / formula);
            }
}

} // namespace
} // namespace tessera::test

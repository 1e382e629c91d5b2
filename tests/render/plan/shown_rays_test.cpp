// tests/render/plan/shown_rays_test.cpp: a ray is visible from the opacity on that the function's integral
// along it has, however narrow the function is against the steps.
#include "render/plan/shown_rays.h"

#include "bricking/import/importer.h"
#include "core/base/program_folders.h"
#include "tests/support/formula_source.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

constexpr glm::ivec3 kExtent{72, 9, 10}; // three bricks along x
constexpr double kSlope = 10;            // values a voxel, along x

struct Ramp {
    MemoryBudget ram{"RAM", "--ram", std::size_t{256} << 20};
    ScratchFolder folder;
    std::unique_ptr<StoreReader> store;

    explicit Ramp(const Formula& value = [](const glm::dvec3& p) { return kSlope * p.x; }) {
        VolumeInfo info;
        info.extentVoxels = kExtent;
        info.type = ValueType::f32;
        FormulaSource source(info, value);
        importToStore(source, folder / "ramp.zarr", ram, {});
        store = std::make_unique<StoreReader>(folder / "ramp.zarr", ram);
    }
};

/// Along x, the field constant beyond the outermost samples.
double depthOf(const TransferFunction& function, double slope = kSlope) {
    constexpr int kSteps = 720000;
    double depth = 0;
    for (int n = 0; n < kSteps; ++n) {
        const double x = (n + 0.5) * kExtent.x / kSteps;
        depth += function.extinction(slope * std::clamp(x, 0.5, kExtent.x - 0.5)) * kExtent.x / kSteps;
    }
    return depth;
}

TEST(ShownRays, CountTheIntegralOfTheFunction) {
    Ramp ramp;
    const VolumeInfo& info = ramp.store->info();
    const Statistics statistics = loadStatistics(*ramp.store, ramp.ram, 1);
    const std::vector<std::vector<OpacityPoint>> functions = {
        {{0, 0.002}, {719, 0.02}},                         // smooth
        {{0, 0.01}, {300, 0}, {500, 0}, {719, 0.03}},      // empty in the middle
        {{331, 0}, {332, 2.5}, {333, 0}},                  // a peak between two steps
        {{11, 0}, {12, 1}, {13, 0}, {640, 0}, {650, 0.2}}, // one near the first entry, and a far one
    };
    for (std::size_t n = 0; n < functions.size(); ++n) {
        const TransferFunction function = TransferFunction::fromExtinction(functions[n], {});
        const TransferTable table = makeTable(function);
        const double depth = depthOf(function);
        const ViewSpace space(info, viewAxes(View::anterior));
        BrickCache cache(*ramp.store, ramp.ram, std::size_t{32} << 20, 1);
        const auto visible = [&](double factor, double x, double along) {
            const ShownRays rays(cache, info, statistics, table, space, nullptr, nullptr,
                                 -std::expm1(-factor * depth), 1);
            LatticeReader samples = rays.reader();
            return rays.onRay(samples, {x, 4.5, 5.5}, glm::dvec3(along, 0, 0));
        };
        // Wherever the ray is looked at, and in both directions; half a step at either end may be left out.
        for (const double x : {3.0, 20.25, 35.0, 68.5})
            for (const double along : {1.0, -1.0}) {
                EXPECT_TRUE(visible(0.96, x, along)) << "function " << n << ", " << x;
                EXPECT_FALSE(visible(1.02, x, along)) << "function " << n << ", " << x;
            }
    }
}

// A field that rises along x by as much as y and z say, and rays between the samples: interpolation along
// every axis counts.
TEST(ShownRays, SeeTheFieldBetweenSamples) {
    const Ramp ramp(
        [](const glm::dvec3& p) { return kSlope * p.x * (1 + 0.2 * (p.y - 4.5) + 0.1 * (p.z - 5.5)); });
    const VolumeInfo& info = ramp.store->info();
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
    const Statistics statistics = loadStatistics(*ramp.store, ram, 1);
    const TransferFunction function = TransferFunction::fromExtinction({{331, 0}, {332, 2.5}, {333, 0}}, {});
    const TransferTable table = makeTable(function);
    const ViewSpace space(info, viewAxes(View::anterior));
    BrickCache cache(*ramp.store, ram, std::size_t{32} << 20, 1);
    for (const glm::dvec2& at : {glm::dvec2(4.1, 5.8), glm::dvec2(4.9, 5.1), glm::dvec2(3.75, 5.5)}) {
        const double depth = depthOf(function, kSlope * (1 + 0.2 * (at.x - 4.5) + 0.1 * (at.y - 5.5)));
        for (const double factor : {0.97, 1.03}) {
            const ShownRays rays(cache, info, statistics, table, space, nullptr, nullptr,
                                 -std::expm1(-factor * depth), 1);
            LatticeReader samples = rays.reader();
            EXPECT_EQ(rays.onRay(samples, {20.25, at.x, at.y}, glm::dvec3(1, 0, 0)), factor < 1)
                << at.x << ", " << at.y;
        }
    }
}

} // namespace
} // namespace tessera::test

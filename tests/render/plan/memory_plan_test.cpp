// tests/render/plan/memory_plan_test.cpp: a plan of memory adds up, and grants exactly what it says.
#include "render/plan/frame_plan.h"

#include "bricking/levels/selection.h"
#include "core/base/error.h"
#include "core/scene/transfer_function.h"
#include "render/contract/optics.h"
#include "render/contract/preintegration.h"
#include "tests/support/surface_fixture.h" // Stored

#include <gtest/gtest.h>

namespace tessera::test {
namespace {

TEST(MemoryPlans, AddUpWhatIsNeeded) {
    MemoryPlan plan;
    EXPECT_EQ(plan.ramBytes(), 0u);
    EXPECT_EQ(plan.gpuBytes(), 0u);
    plan.need("a", 5, 70);
    plan.need("b", 300, 0);
    plan.need("c", 0, 1000);
    plan.need("a", 20000, 400000);
    EXPECT_EQ(plan.ramBytes(), 20305u);
    EXPECT_EQ(plan.gpuBytes(), 401070u);
    EXPECT_FALSE(plan.grant("luxury", 1, 0, 1, 1)) << "nothing is spare";
    EXPECT_FALSE(plan.grant("luxury", 0, 1, 1, 1));
    EXPECT_EQ(plan.ramBytes(), 20305u);
}

TEST(MemoryPlans, GrantThePartThatTheySayAndNoByteMore) {
    for (const bool later : {false, true}) {
        MemoryPlan plan = later ? MemoryPlan() : MemoryPlan(1600, 300);
        if (later)
            plan.setSpare(1600, 300);
        plan.need("small", 7, 8);
        plan.need("large", 1000, 2000);
        EXPECT_FALSE(plan.grant("x", 101, 75, 16, 4, "small"));
        EXPECT_FALSE(plan.grant("x", 100, 76, 16, 4, "small"));
        EXPECT_EQ(plan.ramBytes(), 1007u) << "what is refused replaces nothing";
        EXPECT_EQ(plan.gpuBytes(), 2008u);
        EXPECT_TRUE(plan.grant("x", 100, 75, 16, 4, "small"));
        EXPECT_EQ(plan.ramBytes(), 1100u);
        EXPECT_EQ(plan.gpuBytes(), 2075u);
        EXPECT_TRUE(plan.grant("y", 50, 0, 31, 8)) << "shares are of what is spare in the beginning";
        EXPECT_EQ(plan.ramBytes(), 1150u);
    }
}

TEST(MemoryPlans, TablesTakeWhatTheirEntriesDo) {
    // An entry: a colour with its extinction, twice, and a number; with sums three more, and five at the
    // ends.
    const std::size_t entry = 16, sums = 3 * 100 * entry + 5 * entry;
    const std::size_t colours = Preintegration2d::bytes(kLevelCount);
    for (const Integrator plain : {Integrator::midpoint, Integrator::linear})
        EXPECT_EQ(tableRamBytes(100, plain), 100 * (2 * entry + 4));
    EXPECT_EQ(tableRamBytes(100, Integrator::preintegrated), 100 * (2 * entry + 4) + sums);
    EXPECT_EQ(tableRamBytes(100, Integrator::preintegrated2d), 100 * (2 * entry + 4) + sums + 2 * colours);
    EXPECT_EQ(integratorGpuBytes(100, Integrator::midpoint), 0u);
    EXPECT_EQ(integratorGpuBytes(100, Integrator::linear), sums);
    EXPECT_EQ(integratorGpuBytes(100, Integrator::preintegrated), sums);
    EXPECT_EQ(integratorGpuBytes(100, Integrator::preintegrated2d), sums + colours);
    for (const Integrator any : {Integrator::midpoint, Integrator::preintegrated2d})
        EXPECT_EQ(tableGpuBytes(100, any), 100 * entry + integratorGpuBytes(100, any));
}

/// Everything shows; half of it bright.
Scene plainScene(const Stored& stored) {
    Scene scene = stored.scene({}, 0, 20);
    scene.volumes[0].transferFunction =
        TransferFunction::fromExtinction({{0, 0.01}, {100, 0.1}}, {{0, {1, 0.5, 0.2}}});
    return scene;
}
Stored rising() {
    return Stored([](const glm::dvec3& p) { return p.x + p.y; }, {70, 40, 33}, true, 1, ValueType::i16);
}

// Of a picture that an engine has not opened yet: what it holds in RAM, and what it leaves for the rest.
TEST(MemoryPlans, OfASceneAreKept) {
    const Stored stored = rising();
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
    const StoreReader reader(stored.folder / "v.zarr", ram);
    const std::size_t before = ram.usedBytes();
    {
        const Planner p = planScene(plainScene(stored), reader, TextureLimits{}, {ram, gpu, 2});
        const FramePlan& plan = p;
        const std::size_t bricks = 3 * 2 * 2, entries = plan.layer().table.entries.size();
        EXPECT_EQ(plan.view.imageCharge.bytes(), 20u * 20 * kPictureBytesPerPixel);
        EXPECT_EQ(plan.layer().selectionCharge.bytes(), bricks * 5);
        EXPECT_EQ(selectionBytes(reader.info()), bricks * 5) << "a level and a mean of every brick";
        EXPECT_EQ(plan.layer().selection.levels.size() * 1 + plan.layer().selection.means.size() * 4,
                  bricks * 5);
        EXPECT_EQ(plan.layer().functionCharge.bytes(),
                  tableRamBytes(entries, plan.layer().optics.integrator));
        EXPECT_EQ(plan.gpuTableBytes(entries), tableGpuBytes(entries, Integrator::midpoint))
            << "as it is named";
        EXPECT_EQ(plan.layer().lightCharge.bytes(), 0u);
        EXPECT_EQ(gpu.usedBytes(), 0u);
        EXPECT_LE(ram.peakBytes(), ram.limitBytes());
        // On the GPU: rays, index, level map, tables and the map of cells.
        const std::size_t held = plan.memory.gpuBytes();
        EXPECT_GE(held, 20u * 20 * 16 + bricks * 8 + entries * 16);
        EXPECT_LE(held, (std::size_t{1} << 20) + entries * 16);
        // RAM that is to stay free: the smallest cache and the staging of uploads, most of all.
        EXPECT_GE(plan.memory.ramBytes(),
                  BrickCache::floorBytes(reader.info(), 2) + stagingBytes(reader.info()));
        EXPECT_LE(plan.memory.ramBytes(),
                  2 * (BrickCache::floorBytes(reader.info(), 2) + stagingBytes(reader.info())) + (1u << 16));
    }
    EXPECT_EQ(ram.usedBytes(), before) << "all is given back";
}

TEST(MemoryPlans, GrowWithWhatAPictureAsksFor) {
    const Stored stored = rising();
    const auto planOf = [&](const Scene& scene) {
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        MemoryBudget gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
        const StoreReader reader(stored.folder / "v.zarr", ram);
        const Planner p = planScene(scene, reader, TextureLimits{}, {ram, gpu, 2});
        return std::pair(p.memory.ramBytes(), p.memory.gpuBytes());
    };
    const Scene plain = plainScene(stored);
    const auto [ram, gpu] = planOf(plain);
    const std::size_t pixels = 20 * 20;
    Scene cut = plain;
    cut.cuts.boxes = {{{10, 10, 10}, {20, 20, 20}, CropBox::Space::voxels, Keep::outside}};
    EXPECT_EQ(planOf(cut).second - gpu, pixels * (3 * 8 / 2 + sizeof(std::size_t))) << "intervals and starts";
    EXPECT_EQ(planOf(cut).first, ram);
    Scene wide = plain;
    wide.imageSize = {40, 20};
    EXPECT_GE(planOf(wide).second - gpu, pixels * 16);
    EXPECT_EQ(planOf(wide).first, ram);
    Scene blind = plain;
    blind.quality.skipping = false;
    EXPECT_LT(planOf(blind).second, gpu);
    EXPECT_LT(planOf(blind).first, ram);
    Scene exact = plain;
    exact.quality.integrator = Integrator::preintegrated;
    MemoryBudget trial("RAM", "--ram", std::size_t{256} << 20);
    const StoreReader reader(stored.folder / "v.zarr", trial);
    MemoryBudget large("GPU memory", "--gpu-memory", std::size_t{64} << 20);
    const std::size_t entries =
        planScene(plain, reader, TextureLimits{}, {trial, large, 2}).layer().table.entries.size();
    EXPECT_EQ(planOf(exact).second - gpu, integratorGpuBytes(entries, Integrator::preintegrated));
    Scene lit = plain;
    lit.lighting.occlusion.emplace();
    lit.shading.on = true;
    EXPECT_GT(planOf(lit).first, ram + (std::size_t{1} << 16)) << "light while it is computed";
    EXPECT_EQ(planOf(lit).second - gpu, 12u * 8) << "another index of bricks";
}

} // namespace
} // namespace tessera::test

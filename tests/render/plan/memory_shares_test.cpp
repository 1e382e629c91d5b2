// tests/render/plan/memory_shares_test.cpp: what a plan takes where a budget has just room for it, and not
// where it is a byte smaller: maps of cells, maps of isosurfaces, tables of integrators.
#include "bricking/cache/brick_cache.h"
#include "render/empty_space/occupancy.h"
#include "render/plan/frame_plan.h"
#include "render/residency/pages.h"
#include "tests/support/surface_fixture.h"

#include <gtest/gtest.h>

namespace tessera::test {
namespace {

struct Sloping {
    Sloping() : stored([](const glm::dvec3& p) { return p.x + p.y; }, {90, 70, 75}, true, 1, ValueType::i16) {
        scene = stored.scene({}, 0, 20);
        scene.volumes[0].transferFunction =
            TransferFunction::fromExtinction({{0, 0.01}, {100, 0.1}}, {{0, {1, 0.5, 0.2}}});
    }
    /// A plan in such budgets, and its floor of RAM.
    struct Planned {
        MapScale scale;
        bool mapsSurfaces;
        Integrator mayTake;
        std::size_t ramFloor, ram, gpu, entries, used;
    };
    Planned in(std::size_t ramBytes, std::size_t gpuBytes) const {
        MemoryBudget ram("RAM", "--ram", ramBytes), gpu("GPU memory", "--gpu-memory", gpuBytes);
        const StoreReader reader(stored.folder / "v.zarr", ram);
        const Planner p = planScene(scene, reader, TextureLimits{}, {ram, gpu, 1}, LevelChoice::oneForAll,
                                    kPictureBytesPerPixel);
        EXPECT_LE(ram.peakBytes(), ramBytes);
        return {p.layer().mapScale,
                p.layer().mapsSurfaces,
                p.mayTake,
                p.ramFloorBytes,
                p.memory.ramBytes(),
                p.memory.gpuBytes(),
                p.layer().table.entries.size(),
                ram.usedBytes()};
    }
    Stored stored;
    Scene scene;
};

constexpr std::size_t kAmple = std::size_t{1} << 30;

// A map of cells where it is a 16th of the RAM beyond the floor, and a quarter of what bricks leave of the
// GPU.
TEST(PlannedMemory, MapsOfCellsAreASmallPart) {
    const Sloping volume;
    const glm::ivec3 extent = volume.stored.info.extentVoxels;
    const std::size_t cells = Occupancy::bytes(extent, MapScale::cells),
                      texels = mapBytes(extent, MapScale::cells);
    const Sloping::Planned ample = volume.in(kAmple, kAmple);
    EXPECT_EQ(ample.scale, MapScale::cells);
    EXPECT_FALSE(ample.mapsSurfaces) << "there are none";
    EXPECT_EQ(volume.in(ample.ramFloor + 16 * cells, kAmple).scale, MapScale::cells);
    const Sloping::Planned less = volume.in(ample.ramFloor + 16 * cells - 1, kAmple);
    EXPECT_EQ(less.scale, MapScale::bricks);
    EXPECT_EQ(ample.ram - less.ram, cells - Occupancy::bytes(extent, MapScale::bricks))
        << "one in place of the other";
    EXPECT_EQ(ample.gpu - less.gpu, texels - mapBytes(extent, MapScale::bricks));
    // What bricks need around one sample, and the rest of the plan, are promised.
    const std::size_t promised =
        ample.gpu - texels + atlasBytes(neighbourhoodPages(true, true), ValueType::i16, TextureLimits{});
    EXPECT_EQ(volume.in(kAmple, promised + 4 * texels).scale, MapScale::cells);
    EXPECT_EQ(volume.in(kAmple, promised + 4 * texels - 1).scale, MapScale::bricks);
}

// Isosurfaces in a volume that shows have a map of their own where it is a 31st and an eighth.
TEST(PlannedMemory, MapsOfSurfacesAreASmallerPart) {
    Sloping volume;
    volume.scene.surfaces = {{80, {1, 1, 1}, 1}};
    const glm::ivec3 extent = volume.stored.info.extentVoxels;
    const std::size_t cells = Occupancy::bytes(extent, MapScale::cells),
                      texels = mapBytes(extent, MapScale::cells);
    const Sloping::Planned ample = volume.in(kAmple, kAmple);
    EXPECT_TRUE(ample.mapsSurfaces);
    EXPECT_TRUE(volume.in(ample.ramFloor + 31 * cells, kAmple).mapsSurfaces);
    EXPECT_FALSE(volume.in(ample.ramFloor + 31 * cells - 1, kAmple).mapsSurfaces);
    const std::size_t promised =
        ample.gpu - 2 * texels + atlasBytes(neighbourhoodPages(true, true), ValueType::i16, TextureLimits{});
    EXPECT_TRUE(volume.in(kAmple, promised + 8 * texels).mapsSurfaces);
    EXPECT_FALSE(volume.in(kAmple, promised + 8 * texels - 1).mapsSurfaces);
    volume.scene.volumes[0].transferFunction = TransferFunction::fromExtinction({}, {});
    EXPECT_FALSE(volume.in(kAmple, kAmple).mapsSurfaces) << "nothing else shows";
}

// An integrator that nobody named uses tables that are a 16th of what is free.
TEST(PlannedMemory, TablesOfIntegratorsAreASixteenth) {
    const Sloping volume;
    const Sloping::Planned ample = volume.in(kAmple, kAmple);
    EXPECT_EQ(ample.mayTake, Integrator::preintegrated2d);
    const std::size_t seen = integratorGpuBytes(ample.entries, Integrator::preintegrated2d);
    EXPECT_EQ(volume.in(kAmple, 16 * seen).mayTake, Integrator::preintegrated2d);
    EXPECT_EQ(volume.in(kAmple, 16 * seen - 1).mayTake, Integrator::preintegrated);
    Sloping nearest;
    nearest.scene.quality.edgeFunction = EdgeFunction::nearest;
    EXPECT_EQ(nearest.in(kAmple, kAmple).mayTake, Integrator::midpoint) << "bricks are not blended";
}

} // namespace
} // namespace tessera::test

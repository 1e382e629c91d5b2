// tests/bricking/meshes/mesh_voxels_test.cpp: voxels of the meshes of real files, by brute force.
#include "bricking/import/meshes/mesh_file.h"
#include "tests/support/folders.h"
#include "tests/support/voxel_checks.h"

#include <cstdlib>
#include <ctime>
#include <gtest/gtest.h>
#include <iostream>

namespace tessera {
namespace {

using namespace tessera::test;

/// TESSERA_TELL=1 tells of voxels and of the processor's seconds.
TEST(MeshVoxels, OfRealFilesHaveNoHoleAndNothingBeyond) {
    if (testData().empty())
        GTEST_SKIP() << "no shared test data (TESSERA_TEST_DATA or ../shared/data)";
    for (const char* name : {"bunny.ply", "horse.ply", "cow.obj", "42400-IDGH.stl"}) {
        const auto file = testData() / "meshes" / name;
        if (!std::filesystem::exists(file))
            GTEST_SKIP() << "no " << file;
        MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30);
        const TriangleMesh mesh = readMesh(file, ram);
        const SceneMesh scene = sceneMesh(mesh, ram);
        for (const int resolution : {64, 256}) {
            const auto start = std::clock();
            const MeshBits bits(std::span(&scene, 1), gridAround(std::span(&scene, 1), resolution), &ram, 2,
                                true);
            const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
            const VoxelFaults faults = faultsOf(bits, inVoxels(mesh, bits.grid()));
            EXPECT_GT(faults.set, 1000u) << name;
            EXPECT_EQ(faults.holes, 0u) << name << " at " << resolution;
            EXPECT_EQ(faults.beyond, 0u) << name << " at " << resolution;
            if (std::getenv("TESSERA_TELL"))
                std::cout << name << " at " << resolution << ": " << mesh.triangles.size() << " triangles, "
                          << faults.set << " voxels, " << bits.bytes() << " bytes, " << seconds << " s\n";
        }
    }
}

} // namespace
} // namespace tessera

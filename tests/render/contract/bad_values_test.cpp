// tests/render/contract/bad_values_test.cpp: values that are no number, or no memory: voxels that are NaN or
// infinite, rays without a direction, and the least budgets. Pictures are finite and in range, or background;
// nothing hangs.
#include "core/base/error.h"
#include "render/picture/render_scene.h"
#include "tests/support/extreme_cases.h"
#ifdef TESSERA_WITH_IMPORT
#include "bricking/import/open_source.h"
#include "tests/support/import_test_tools.h" // writeFile
#endif

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr Integrator kIntegrators[] = {Integrator::midpoint, Integrator::linear, Integrator::preintegrated,
                                       Integrator::preintegrated2d};

#ifdef TESSERA_WITH_IMPORT
constexpr glm::ivec3 kExtent(35, 33, 34);  // two bricks along every axis
constexpr unsigned kBadVoxels = 5 * 4 * 5; // telling places along each; along y the last voxel is the 32nd

/// A smooth field; bad values at the corners, edges and faces of volume and bricks, and inside.
std::string floats(bool bad) {
    constexpr float kBad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                              -std::numeric_limits<float>::infinity()};
    constexpr int kOrdinary = 16;
    const auto telling = [](int at, int extent) {
        return at == 0 || at == extent - 1 || at == 31 || at == 32 || at == kOrdinary;
    };
    std::vector<float> values;
    std::vector<std::size_t> toldApart;
    float lowest = std::numeric_limits<float>::max(); // of the others: what formats.md says of them
    for (int z = 0; z < kExtent.z; ++z)
        for (int y = 0; y < kExtent.y; ++y)
            for (int x = 0; x < kExtent.x; ++x) {
                if (telling(x, kExtent.x) && telling(y, kExtent.y) && telling(z, kExtent.z))
                    toldApart.push_back(values.size());
                values.push_back(std::sin(0.2f * static_cast<float>(x + y)) + 0.03f * static_cast<float>(z));
                if (toldApart.empty() || toldApart.back() + 1 != values.size())
                    lowest = std::min(lowest, values.back());
            }
    for (std::size_t n = 0; n < toldApart.size(); ++n)
        values[toldApart[n]] = bad ? kBad[n % 3] : lowest;
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)};
}

// Bad voxels are counted and drawn as the lowest value, by every integrator, bit by bit.
TEST(BadVoxels, AreDrawnAsTheLowestValue) {
    const GlContext context({"software"});
    const ScratchFolder folder;
    for (const bool bad : {true, false}) {
        const std::string name = bad ? "bad" : "good";
        writeFile(folder / (name + ".raw"), floats(bad));
        writeFile(folder / (name + ".json"), "{\"data\": \"" + name +
                                                 ".raw\", \"type\": \"float32\", \"extent\": [35, 33, 34], "
                                                 "\"spacing\": [0.5, 0.5, 0.5]}");
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        ImportOptions options;
        options.durable = false;
        importToStore(*openSource(folder / (name + ".json"), {}), folder / (name + ".zarr"), ram, options);
        EXPECT_EQ(StoreReader(folder / (name + ".zarr"), ram).info().nonFiniteVoxels, bad ? kBadVoxels : 0u);
    }
    for (const Integrator integrator : kIntegrators)
        for (const Fetch fetch : {Fetch::exact, Fetch::hardware}) {
            std::array<Image, 2> pictures;
            for (const bool bad : {true, false}) {
                MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
                const VolumeInfo info = StoreReader(folder / (bad ? "bad.zarr" : "good.zarr"), ram).info();
                Scene scene = sceneOn(info, "auto", 2, {14, 11});
                scene.quality.integrator = integrator;
                scene.quality.fetch = fetch;
                Prepared prepared((folder / (bad ? "bad" : "good")).string(), scene);
                pictures[bad] = marchOn(prepared, marchFeatures(prepared.p, true)).image;
                expectInRange(widened(pictures[bad].pixels), scene, "march");
            }
            EXPECT_FALSE(isBlank(pictures[0]));
            EXPECT_TRUE(bitEqual(pictures[0], pictures[1]));
        }
}
#endif

// A ray whose direction is nothing, infinite or no number draws nothing, on the CPU and on the GPU, and ends.
TEST(BadRays, DrawNothing) {
    const GlContext context({"software"});
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const double bad : {0.0, static_cast<double>(nan), std::numeric_limits<double>::infinity()})
        for (const bool perspective : {false, true})
            for (const bool everywhere : {false, true}) {
                SCOPED_TRACE(testing::Message() << bad << (perspective ? ", perspective" : ", parallel"));
                MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
                Scene scene = sceneOn(StoreReader(storePath("sphere"), ram).info(), "auto",
                                      perspective ? 0 : 1, {9, 8});
                Prepared prepared("sphere", scene);
                Planner& p = prepared.p;
                // Nothing in all components is no direction; no number in one is no direction either.
                p.view.frame.toCentre[1] = bad;
                if (everywhere || bad == 0)
                    p.view.frame.toCentre = glm::dvec3(bad);
                if (bad == 0 && perspective)
                    p.view.frame.right = p.view.frame.up =
                        glm::dvec3(0); // else pixels beside the centre have one
                Slicing slicing;
                slicing.fixedTile = 64;
                slicing.fixedIterations = 64;
                const GpuPicture gpu = marchOn(prepared, marchFeatures(p, true), slicing);
                Work work;
                const auto mirror = mirrorRays<float>(mirrorInput(p, true), 72,
                                                      frameRays(cast<float>(p.view.frame)), 1, work);
                for (std::size_t i = 0; i < mirror.size(); ++i) {
                    ASSERT_EQ(gpu.image.pixels[i], glm::vec4(0)) << i;
                    ASSERT_EQ(mirror[i], glm::vec4(0)) << i;
                }
                EXPECT_LE(gpu.work.dispatches, 2u);
            }
}

/// The least budget of GPU memory that is accepted, within a hundredth.
std::size_t leastGpuBytes(const Scene& scene, const StoreReader& store) {
    std::size_t refused = 1, accepted = std::size_t{1} << 24;
    while (accepted - refused > accepted / 100) {
        const std::size_t middle = refused + (accepted - refused) / 2;
        MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30), gpu("GPU memory", "--gpu-memory", middle);
        try {
            planScene(scene, store, TextureLimits{}, {ram, gpu, 1});
            accepted = middle;
        } catch (const InputError&) {
            refused = middle;
        }
    }
    return accepted;
}

// Nasty scenes by the whole renderer, with levels chosen per brick in the least accepted memory. Bricks have
// several levels, and a requested quality takes several passes.
TEST(SmallBudgets, DrawNastyScenesInRange) {
    ExtremeStores stores;
    int mixedPictures = 0, drawn = 0;
    for (ExtremeCase& c : randomCases(400, 99)) {
        // Bricks enough for levels to differ, and few programs.
        if (c[kVolume] > 2 || c.structure().fetch != Fetch::exact || c[kStructure] > 3 ||
            c.structure().integrator == Integrator::preintegrated2d)
            continue;
        SCOPED_TRACE(c);
        const ExtremeVolume volume = volumeOf(c);
        Scene scene = sceneOf(c, volume);
        if (drawn % 3 == 0)
            scene.quality.maxError = 0;
        MemoryBudget storeRam("RAM", "--ram", std::size_t{64} << 20);
        const StoreReader store(stores.path(c) + ".zarr", storeRam);
        const_cast<VolumeInfo&>(store.info()).patientFromVoxel = volume.info.patientFromVoxel;
        const std::size_t least = leastGpuBytes(scene, store);
        for (const std::size_t extra :
             {std::size_t{0}, std::size_t{3} << 16}) { // three pages of 16-bit texels
            MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30),
                gpu("GPU memory", "--gpu-memory", least + extra);
            RenderOptions options;
            options.device.text = "software";
            const RenderResult result = renderScene(scene, store, ram, gpu, options);
            expectInRange(widened(result.image.pixels), scene, "march");
            EXPECT_LE(gpu.peakBytes(), least + extra);
            int levels = 0;
            for (std::size_t l = 0; l < kLevelCount; ++l)
                levels += result.bricksOfLevel[l] > 0 ? 1 : 0;
            mixedPictures += levels > 1 ? 1 : 0;
        }
        if (++drawn == 40)
            break;
    }
    std::printf("%d scenes, %d pictures of several levels\n", drawn, mixedPictures);
    EXPECT_GE(drawn, 20);
    EXPECT_GE(mixedPictures, 5);
}

} // namespace
} // namespace tessera

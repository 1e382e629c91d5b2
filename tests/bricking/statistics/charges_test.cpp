// tests/bricking/statistics/charges_test.cpp: what is held while statistics and labels are made is charged
// before: the program's heap never holds more than the budget says, but for what does not grow with volumes.
#include "tests/support/counted_heap.h"

#include "bricking/mask/masked_source.h"
#include "bricking/statistics/coarse_statistics.h"
#include "bricking/statistics/local_histograms.h"
#include "bricking/statistics/statistics.h"
#include "tests/support/bricking_store_tools.h"
#include "tests/support/label_tools.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <string>

namespace tessera::test {
namespace {

constexpr std::size_t kSmall = std::size_t{400} << 10; // tables of libraries, paths, JSON, threads

/// Runs something with a budget; the heap may hold what the budget had at most, and little more.
void expectCharged(const std::string& what, const std::function<void(MemoryBudget&)>& run,
                   std::size_t limit = kPlenty) {
#ifndef __SANITIZE_ADDRESS__
    MemoryBudget ram("RAM", "--ram", limit);
    const std::size_t before = liveBytes;
    peakBytes = before;
    run(ram);
    const std::size_t held = peakBytes - before;
    EXPECT_LT(held, ram.peakBytes() + kSmall) << what;
    EXPECT_EQ(ram.usedBytes(), 0U) << what;
#endif
}

struct Charges : ::testing::TestWithParam<ValueType> {
    ScratchFolder folder;
    MemoryBudget plenty{"RAM", "--ram", std::size_t{1} << 30};
    VolumeInfo info = [] {
        VolumeInfo all = plainInfo({130, 150, 140}, GetParam());
        all.unit = "HU";
        return all;
    }();
    std::unique_ptr<StoreReader> store;
    void SetUp() override {
        HashSource source(info, [](int x, int y, int z) {
            return std::floor(100 + 60 * std::sin(x / 9.0) * std::cos(y / 7.0) + 20 * std::sin(z / 5.0));
        });
        import(folder / "s.zarr", source);
        store = std::make_unique<StoreReader>(folder / "s.zarr", plenty);
    }
};
INSTANTIATE_TEST_SUITE_P(Types, Charges, ::testing::Values(ValueType::u8, ValueType::f32),
                         [](const auto& type) { return std::to_string(static_cast<int>(type.param)); });

TEST_P(Charges, OfStatisticsAreWhatTheyHold) {
    constexpr int kThreads = 3;
    expectCharged("load", [&](MemoryBudget& ram) { (void)loadStatistics(*store, ram, kThreads); });
    expectCharged("coarse", [&](MemoryBudget& ram) { (void)loadCoarseStatistics(*store, ram, kThreads); });
    expectCharged("of a level", [&](MemoryBudget& ram) {
        const Statistics all = loadStatistics(*store, ram, kThreads);
        (void)boundsOfLevel(all, info, 1, ram, kThreads);
    });
    for (const std::size_t limit : {kPlenty, buildStatisticsFloorBytes(info, kThreads)})
        expectCharged(
            "build in " + std::to_string(limit),
            [&](MemoryBudget& ram) { buildStatistics(*store, folder / "built", ram, kThreads); }, limit);
    expectCharged("histograms", [&](MemoryBudget& ram) {
        const Statistics all = loadStatistics(*store, ram, kThreads);
        (void)makeLocalHistograms(*store, all, {}, ram, kThreads);
    });
    expectCharged("hidden", [&](MemoryBudget& ram) {
        Statistics all = loadStatistics(*store, ram, kThreads);
        std::vector<std::uint8_t> shares(cellCount(levelExtent(info.extentVoxels, 1)));
        std::fill(shares.begin(), shares.begin() + static_cast<std::ptrdiff_t>(shares.size() / 2),
                  std::uint8_t{255});
        const auto mask = std::make_shared<const Mask>(info.extentVoxels, 1, std::move(shares), ram);
        const MaskedSource masked(*store, mask, 0, ram, kThreads);
        hideMasked(all, masked, ram, kThreads);
    });
    // As they are where none are kept.
    const StoreReader bare = [&] {
        std::filesystem::copy(folder / "s.zarr", folder / "bare.zarr",
                              std::filesystem::copy_options::recursive |
                                  std::filesystem::copy_options::overwrite_existing);
        std::filesystem::remove_all(folder / "bare.zarr" / "stats");
        return StoreReader(folder / "bare.zarr", plenty);
    }();
    for (const std::size_t limit : {kPlenty, statisticsFloorBytes(info, kThreads)})
        expectCharged(
            "make in " + std::to_string(limit),
            [&](MemoryBudget& ram) { (void)loadStatistics(bare, ram, kThreads); }, limit);
}

TEST(LabelCharges, AreWhatAnImportHolds) {
    const glm::ivec3 extent(110, 100, 60);
    const VolumeInfo scan = gridOf(extent, glm::dmat4(1));
    const Values values = blobs(extent, {1, 2, 7, 300}, 1);
    const auto placed = [&](const glm::dmat4& affine, const glm::ivec3& size) {
        return HeldLayer(gridOf(size, affine), blobs(size, {1, 2, 7}, 2));
    };
    glm::dmat4 finer = glm::scale(glm::dmat4(1), glm::dvec3(0.4, 0.45, 0.5)),
               turned = glm::rotate(glm::translate(glm::dmat4(1), {2, -3, 1}), 0.2, {0.3, 0.5, 1}), other(0);
    other[0] = {0, 1, 0, 0}, other[1] = {0, 0, 1, 0}, other[2] = {1, 0, 0, 0}, other[3] = {0, 0, 0, 1};
    const std::pair<const char*, HeldLayer> layers[] = {
        {"the same", HeldLayer(scan, values)},
        {"another order", HeldLayer(gridOf({extent.y, extent.z, extent.x}, other), values)},
        {"finer", placed(finer, {220, 200, 110})},
        {"turned", placed(turned, extent)}};
    constexpr int kThreads = 3;
    const ScratchFolder scratch;
    for (const auto& [name, layer] : layers)
        for (const bool scarce : {false, true}) {
            LabelFile file = fileOf({layer});
            const std::size_t limit = scarce ? labelImportFloorBytes(file, scan, kThreads) : kPlenty;
            LabelImportOptions options = quickly(kThreads);
            options.force = true;
            expectCharged(
                std::string(name) + (scarce ? " at its floor" : ""),
                [&](MemoryBudget& ram) { importLabels(file, scan, scratch / "l.zarr", ram, options); },
                limit);
        }
}

} // namespace
} // namespace tessera::test

// tests/bricking/import/importer_test.cpp: importing keeps its budget, replaces nothing unasked, and leaves
// nothing behind when it fails.
#include "tests/support/bricking_store_tools.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Import, AnExistingStoreIsReplacedOnlyByForce) {
    ScratchFolder scratch;
    HashSource first(plainInfo({5, 6, 7}, ValueType::u8));
    import(scratch / "v.zarr", first, false, 1, kPlenty, true);
    HashSource second(plainInfo({8, 8, 8}, ValueType::i16));
    EXPECT_THAT([&] { import(scratch / "v.zarr", second); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("v.zarr"), HasSubstr("--force"))));
    MemoryBudget ram("RAM", "--ram", kPlenty);
    EXPECT_EQ(StoreReader(scratch / "v.zarr", ram).info().extentVoxels, glm::ivec3(5, 6, 7));
    import(scratch / "v.zarr", second, true, 1, kPlenty, true);
    EXPECT_EQ(StoreReader(scratch / "v.zarr", ram).info().extentVoxels, glm::ivec3(8, 8, 8));
    EXPECT_EQ(entriesIn(scratch.path()), 1u);
}

TEST(Import, WhatIsNoStoreIsNeverReplaced) {
    ScratchFolder scratch;
    fs::create_directory(scratch / "photos");
    setFileText(scratch / "photos/zarr.json", "{}");
    HashSource source(plainInfo({5, 6, 7}, ValueType::u8));
    EXPECT_THROW(import(scratch / "photos", source, true), InputError);
    EXPECT_EQ(fileText(scratch / "photos/zarr.json"), "{}");
    EXPECT_FALSE(isStore(scratch / "photos"));
    EXPECT_THROW(import(scratch / "no-such-folder/v.zarr", source), InputError);
}

TEST(Import, AFailingSourceLeavesNothingBehind) {
    ScratchFolder scratch;
    HashSource good(plainInfo({40, 40, 10}, ValueType::u8));
    import(scratch / "v.zarr", good);
    HashSource source(plainInfo({40, 40, 100}, ValueType::u8));
    source.failAtZ = 70;
    EXPECT_THROW(import(scratch / "v.zarr", source, true), InputError);
    EXPECT_EQ(entriesIn(scratch.path()), 1u);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    EXPECT_EQ(StoreReader(scratch / "v.zarr", ram).info().extentVoxels.z, 10) << "the old store must stay";
    VolumeInfo info = plainInfo({4, 4, 4}, ValueType::f32);
    HashSource hole(info, [](int x, int, int) { return x == 2 ? NAN : 1; });
    EXPECT_THROW(import(scratch / "hole.zarr", hole), InputError);
    EXPECT_EQ(entriesIn(scratch.path()), 1u);
}

TEST(Import, WhatCannotBeStoredIsRefused) {
    ScratchFolder scratch;
    const auto refused = [&](auto change) {
        VolumeInfo info = plainInfo({4, 4, 4}, ValueType::u8);
        change(info);
        HashSource source(info);
        EXPECT_THROW(import(scratch / "v.zarr", source), InputError);
    };
    refused([](VolumeInfo& info) { info.extentVoxels.y = 0; });
    refused([](VolumeInfo& info) { info.fillStored = 300; });
    refused([](VolumeInfo& info) { info.fillStored = 0.5; });
    refused([](VolumeInfo& info) { info.type = ValueType::u16, info.fillStored = 65536; });
    refused([](VolumeInfo& info) { info.type = ValueType::i16, info.fillStored = -32769; });
    refused([](VolumeInfo& info) { info.type = ValueType::f32, info.fillStored = 0.1; });
    refused([](VolumeInfo& info) { info.patientFromVoxel[2] = info.patientFromVoxel[1]; });
    refused([](VolumeInfo& info) { info.rescaleSlope = 0; });
    refused([](VolumeInfo& info) { info.acquisition.tubeVoltageKv = NAN; });
    EXPECT_EQ(entriesIn(scratch.path()), 0u);
}

// Some things are known only when the last slice has been read: the store tells them all the same.
TEST(Import, WhatASourceFindsOutWhileItIsReadIsKept) {
    class Learning final : public HashSource {
      public:
        using HashSource::HashSource;
        const VolumeInfo& info() const override { return learnt_; }
        void readSlices(int count, std::span<std::byte> out) override {
            HashSource::readSlices(count, out);
            learnt_.lossy = true;
            learnt_.nonFiniteVoxels += 2;
            learnt_.clampedVoxels += 5;
            learnt_.absentStored = -7;
        }

      private:
        VolumeInfo learnt_ = HashSource::info();
    };
    ScratchFolder scratch;
    Learning source(plainInfo({4, 3, 40}, ValueType::i16)); // two slabs
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const VolumeInfo info = StoreReader(scratch / "v.zarr", ram).info();
    EXPECT_TRUE(info.lossy);
    EXPECT_EQ(info.nonFiniteVoxels, 4u);
    EXPECT_EQ(info.clampedVoxels, 10u);
    EXPECT_EQ(info.absentStored, -7);
}

TEST(Import, AUnitIsGivenWhereThereIsNoneAndNeverReplaced) {
    ScratchFolder scratch;
    MemoryBudget ram("RAM", "--ram", kPlenty);
    ImportOptions options;
    options.durable = false;
    options.unit = "HU";
    for (const char* unit : {"", "HU", "mm"}) {
        VolumeInfo info = plainInfo({4, 3, 2}, ValueType::i16);
        info.unit = unit;
        HashSource source(info);
        const fs::path store = scratch / (std::string("v") + unit + ".zarr");
        if (std::string(unit) == "mm") {
            EXPECT_THROW(importToStore(source, store, ram, options), InputError);
            continue;
        }
        importToStore(source, store, ram, options);
        EXPECT_EQ(StoreReader(store, ram).info().unit, "HU");
    }
}

TEST(Import, KeepsItsBudgetAndNamesTheFloor) {
    for (const glm::ivec3& extent : {glm::ivec3(1, 1, 1), glm::ivec3(70, 90, 130), glm::ivec3(600, 20, 5)})
        for (const ValueType type : {ValueType::u8, ValueType::f32})
            for (const int threads : {1, 3}) {
                ScratchFolder scratch;
                const VolumeInfo info = plainInfo(extent, type);
                HashSource refused(info);
                const std::size_t floor = importFloorBytes(refused, info, threads);
                EXPECT_THAT(
                    [&] { import(scratch / "v.zarr", refused, false, threads, floor - 1); },
                    ThrowsMessage<InputError>(AllOf(HasSubstr(formatBytes(floor)), HasSubstr("--ram"))));
                EXPECT_EQ(entriesIn(scratch.path()), 0u);
                HashSource source(info);
                import(scratch / "v.zarr", source, false, threads, floor); // checks the peak
                MemoryBudget ram("RAM", "--ram", kPlenty);
                EXPECT_EQ(readLevel(StoreReader(scratch / "v.zarr", ram), 0).at(0), source.valueAt(0, 0, 0));
            }
}

} // namespace
} // namespace tessera

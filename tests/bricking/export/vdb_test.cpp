// tests/bricking/export/vdb_test.cpp: OpenVDB reads the grids that were written.
#include "tests/support/export_tools.h"

#include <gmock/gmock.h>
#include <openvdb/openvdb.h>

namespace tessera::test {
namespace {

openvdb::FloatGrid::Ptr gridOf(const fs::path& path) {
    openvdb::initialize();
    openvdb::io::File file(path.string());
    file.open(false);
    return openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("density"));
}

TEST(ExportVdb, EveryTypeBoxAndLevelReadsBack) {
    forEachStoreToExport([](const StoreReader& store, const ScratchFolder& scratch, ValueType type) {
        for (const LevelBox& box : boxesFor(store.info())) {
            const bool packed = box.level == 2;
            exportBox("vdb", store, box, scratch / "v.vdb", packed);
            const openvdb::FloatGrid::Ptr grid = gridOf(scratch / "v.vdb");
            const std::vector<double> expected = expectedValues(store, box);
            const auto lowest = static_cast<float>(*std::min_element(expected.begin(), expected.end()));
            EXPECT_EQ(grid->background(), lowest);
            EXPECT_EQ(grid->getGridClass(), openvdb::GRID_FOG_VOLUME);
            openvdb::FloatGrid::ConstAccessor at = grid->getConstAccessor();
            std::size_t wrong = 0, above = 0;
            for (std::size_t i = 0; i < expected.size(); ++i) {
                const glm::ivec3 p = gridPosition(i, box.extent());
                float value = 0;
                const bool active = at.probeValue(openvdb::Coord(p.x, p.y, p.z), value);
                wrong += value != static_cast<float>(expected[i]) || active != (value != lowest);
                above += value != lowest;
            }
            EXPECT_EQ(wrong, 0u) << name(type) << " level " << box.level;
            EXPECT_EQ(grid->activeVoxelCount(), above) << "nothing beyond the box";
            std::vector<glm::dvec3> centres;
            for (const openvdb::Vec3d& index : {openvdb::Vec3d(0, 0, 0), openvdb::Vec3d(1, 0, 0),
                                                openvdb::Vec3d(0, 1, 0), openvdb::Vec3d(0, 0, 1)}) {
                const openvdb::Vec3d mm = grid->indexToWorld(index);
                centres.emplace_back(mm.x(), mm.y(), mm.z());
            }
            expectPlace(store.info(), box, centres, 1e-9, "vdb");
        }
    });
}

TEST(ExportVdb, HalvesRoundAndTilesStand) {
    const ScratchFolder scratch;
    VolumeInfo info = asymmetricInfo(ValueType::i16);
    HashSource source(info, [](int x, int y, int) { return x < 20 ? 7.0 : x < 30 ? 100.0 : x + 3 * y; });
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    const LevelBox box = wholeLevel(info, 0);
    exportBox("vdb", store, box, scratch / "float.vdb");
    exportBox("vdb-half", store, box, scratch / "half.vdb");
    EXPECT_LT(fs::file_size(scratch / "half.vdb"), 6 * fs::file_size(scratch / "float.vdb") / 10);
    const openvdb::FloatGrid::Ptr grid = gridOf(scratch / "half.vdb");
    const std::vector<double> expected = expectedValues(store, box);
    openvdb::FloatGrid::ConstAccessor at = grid->getConstAccessor();
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const glm::ivec3 p = gridPosition(i, box.extent());
        ASSERT_EQ(at.getValue(openvdb::Coord(p.x, p.y, p.z)), static_cast<float>(expected[i])) << i;
    }
}

TEST(ExportVdb, AGridThatDoesNotFitIsRefused) {
    const ScratchFolder scratch;
    HashSource source(asymmetricInfo(ValueType::u16));
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    const LevelBox box = wholeLevel(store.info(), 0);
    EXPECT_THAT([&] { exportBox("vdb", store, box, scratch / "v.vdb", false, std::size_t{600} << 10); },
                ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("--ram")));
    EXPECT_EQ(entriesIn(scratch.path()), 1u);
}

// Halves end at 65504.
TEST(ExportVdb, HalvesDoNotBecomeInfinite) {
    for (const bool fits : {true, false}) {
        const ScratchFolder scratch;
        HashSource source(plainInfo({9, 8, 7}, ValueType::u16), [=](int x, int, int) {
            return x > 0 ? 5.0 : fits ? 65504.0 : 65505.0;
        });
        import(scratch / "v.zarr", source);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v.zarr", ram);
        const auto write = [&] {
            exportBox("vdb-half", store, wholeLevel(store.info(), 0), scratch / "v.vdb");
        };
        if (fits)
            EXPECT_NO_THROW(write());
        else
            EXPECT_THAT(write, ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("65505")));
    }
}

} // namespace
} // namespace tessera::test

// tests/bricking/store/ome_test.cpp: a store's metadata for other programs, in numbers worked out by hand:
// the position of each level, the directions of axes, and the window of soft tissue. Its content hash detects
// any change.
#include "tests/support/bricking_store_tools.h"

#include "bricking/store/checked_json.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace test;

/// `attributes.ome` of a store of 40 x 36 x 70 voxels of 0.5 x 0.75 x 2 mm, the first centred at (10, 20,
/// 30).
Json omeOf(VolumeInfo info) {
    const ScratchFolder scratch;
    info.extentVoxels = {40, 36, 70};
    HashSource source(info);
    import(scratch / "v.zarr", source);
    return parseJson(fileText(scratch / "v.zarr/zarr.json"), "zarr.json").at("attributes").at("ome");
}
VolumeInfo plainBox() {
    VolumeInfo info = plainInfo({40, 36, 70}, ValueType::i16);
    info.patientFromVoxel = patientFromVoxelOf({10, 20, 30}, {0.5, 0, 0}, {0, 0.75, 0}, {0, 0, 2});
    return info;
}

TEST(OmeMetadata, LevelsLieWhereTheirSamplesAre) {
    const Json ome = omeOf(plainBox());
    const Json& datasets = ome.at("multiscales").at(0).at("datasets");
    ASSERT_EQ(datasets.size(), 6u);
    for (int level = 0; level < 6; ++level) {
        const double pitch = 1 << level;
        const Json& transforms = datasets.at(static_cast<std::size_t>(level)).at("coordinateTransformations");
        EXPECT_EQ(transforms.at(0).at("scale"), Json({2 * pitch, 0.75 * pitch, 0.5 * pitch})) << level;
        // Level l begins where level 0 does: half a voxel before its first centre, then half a sample on.
        EXPECT_EQ(transforms.at(1).at("translation"),
                  Json({30 - 1 + pitch, 20 - 0.375 + 0.375 * pitch, 10 - 0.25 + 0.25 * pitch}))
            << level;
    }
}

TEST(OmeMetadata, AxesSayWhereTheyPoint) {
    const auto axesOf = [](const VolumeInfo& info) {
        std::vector<std::string> said;
        const Json ome = omeOf(info);
        for (const Json& axis : ome.at("multiscales").at(0).at("axes"))
            said.push_back(
                axis.at("name").get<std::string>() + " " +
                (axis.contains("orientation") ? axis["orientation"]["value"].get<std::string>() : ""));
        return said;
    };
    VolumeInfo info = plainBox(); // LPS: x grows to the patient's left
    EXPECT_EQ(axesOf(info), (std::vector<std::string>{"z inferior-to-superior", "y anterior-to-posterior",
                                                      "x right-to-left"}));
    info.patientFromVoxel = patientFromVoxelOf({10, 20, 30}, {-0.5, 0, 0}, {0, 0.1, -0.75}, {0, -2, 0.2});
    EXPECT_EQ(axesOf(info), (std::vector<std::string>{"z posterior-to-anterior", "y superior-to-inferior",
                                                      "x left-to-right"}));
    info.patientFromVoxel = patientFromVoxelOf({10, 20, 30}, {0.5, 0, 0}, {0.4, 0.3, 0}, {0, 0, 2});
    EXPECT_EQ(axesOf(info), (std::vector<std::string>{"z ", "y ", "x "})) << "two of them along x";
}

TEST(OmeMetadata, TheWindowShowsSoftTissue) {
    VolumeInfo info = plainBox();
    info.unit = "HU";
    for (const double slope : {2.0, -2.0}) {
        info.rescaleSlope = slope;
        info.rescaleIntercept = -1000;
        const Json ome = omeOf(info);
        const Json& window = ome.at("omero").at("channels").at(0).at("window");
        EXPECT_EQ(window.at("start"), slope > 0 ? 420 : -620); // stored values of -160 and 240 HU
        EXPECT_EQ(window.at("end"), slope > 0 ? 620 : -420);
    }
}

// Without a unit all there is: extremes in the last column, row and slice are part of it.
TEST(OmeMetadata, TheWindowHoldsEveryValue) {
    const ScratchFolder scratch;
    HashSource source(plainBox(), [](int x, int y, int z) {
        return x == 39 && y == 17 && z == 9 ? -700 : x == 20 && y == 35 && z == 69 ? 900 : 1;
    });
    import(scratch / "v.zarr", source);
    const Json document = parseJson(fileText(scratch / "v.zarr/zarr.json"), "zarr.json");
    const Json& channel = document.at("attributes").at("ome").at("omero").at("channels").at(0);
    EXPECT_EQ(channel.at("window"), Json({{"min", -700}, {"max", 900}, {"start", -700.0}, {"end", 900.0}}));
}

/// A constant that is added to every value moves the window by as much, on whichever side of 0 it comes to
/// lie.
TEST(OmeMetadata, TheWindowMovesWithTheValues) {
    for (const int shift : {-20000, -101, -50, 0, 1, 20000}) {
        const ScratchFolder scratch;
        HashSource source(plainBox(), [shift](int x, int y, int z) { return shift + (x + y + z) % 101; });
        import(scratch / "v.zarr", source);
        const Json attributes =
            parseJson(fileText(scratch / "v.zarr/zarr.json"), "zarr.json").at("attributes");
        const Json& window = attributes.at("ome").at("omero").at("channels").at(0).at("window");
        EXPECT_EQ(window.at("min"), shift) << shift;
        EXPECT_EQ(window.at("max"), shift + 100) << shift;
    }
}

/// A window is one of stored values: what they mean moves its ends, and its limits not at all.
TEST(OmeMetadata, TheWindowsLimitsAreStoredValues) {
    const auto windowOf = [](double slope, double intercept) {
        VolumeInfo info = plainBox();
        info.rescaleSlope = slope;
        info.rescaleIntercept = intercept;
        const ScratchFolder scratch;
        HashSource source(info, [](int x, int y, int z) { return 7 + (x + y + z) % 101; });
        import(scratch / "v.zarr", source);
        const Json attributes =
            parseJson(fileText(scratch / "v.zarr/zarr.json"), "zarr.json").at("attributes");
        return attributes.at("ome").at("omero").at("channels").at(0).at("window");
    };
    const Json expected = {{"min", 7}, {"max", 107}, {"start", 7.0}, {"end", 107.0}};
    for (const double slope : {1.0, 0.5, -3.0})
        EXPECT_EQ(windowOf(slope, -1000), expected) << slope;
}

// A bit of the first of several chunks of one shard, none of which changes its length by it.
TEST(ContentHash, TellsEveryBit) {
    const ScratchFolder scratch;
    MemoryBudget ram("RAM", "--ram", kPlenty);
    std::vector<std::string> hashes;
    for (const int flip : {0, 1}) {
        HashSource source(plainInfo({70, 40, 40}, ValueType::u16), [flip](int x, int y, int z) {
            const auto v =
                static_cast<int>(mixed(static_cast<std::uint64_t>((z * 100 + y) * 100 + x)) & 0xFFFF);
            return x == 1 && y == 2 && z == 3 ? v ^ flip : v;
        });
        const fs::path store = scratch / std::to_string(flip);
        import(store, source);
        hashes.push_back(StoreReader(store, ram).contentHash());
    }
    EXPECT_EQ(fs::file_size(scratch / "0/0/c/0/0/0"), fs::file_size(scratch / "1/0/c/0/0/0"));
    EXPECT_NE(hashes[0], hashes[1]);
}

} // namespace
} // namespace tessera

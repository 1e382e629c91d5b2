// tests/bricking/labels/zarr_labels_test.cpp: labels in OME-Zarr and in arrays of Zarr: every type, order and
// compression, places, names and colours, and samples that other programs wrote.
#include "bricking/import/labels/open_labels.h"
#include "bricking/labels/label_import.h"
#include "bricking/store/store_writer.h"
#include "core/image/colour.h"
#include "tests/support/label_tools.h"
#include "tests/support/refusals.h"
#include "tests/support/zarr_label_image.h"

namespace tessera::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(ZarrLabels, EveryOrderAndCompressionKeepsItsValues) {
    const auto folder = labelTestFolder();
    const auto values = zarrLabelValues(7 * 11 * 13);
    int number = 0;
    for (const int version : {2, 3})
        for (const std::string compressor : {"none", "blosc", "zstd", "gzip", "zlib"})
            for (const int how : {0, 1, 2, 3, 4, 5, 6}) {
                WrittenZarr zarr;
                zarr.version = version;
                zarr.compressor = compressor;
                zarr.shape = kShape;
                zarr.chunk = how == 1   ? std::vector<std::size_t>{7, 11, 13}
                             : how == 2 ? std::vector<std::size_t>{1, 20, 2}
                                        : std::vector<std::size_t>{3, 4, 5};
                zarr.bigEndian = how == 3;
                zarr.hasKnownSize = how != 4;
                if (how == 4)
                    zarr.order = {2, 1, 0};
                if (how == 3)
                    zarr.separator = ".";
                zarr.fill = how == 2 ? 7 : 0;
                if (version == 3 && compressor != "zlib") {
                    zarr.hasCrc = how % 2 == 1;
                    if (how == 0)
                        zarr.order = {1, 2, 0};
                    if (how >= 5)
                        zarr.shard = {6, 8, 15};
                    zarr.isIndexInFront = how == 6;
                } else if (how >= 5 || (version == 3 && compressor == "zlib")) {
                    continue;
                }
                SCOPED_TRACE(std::to_string(version) + " " + compressor + " " + std::to_string(how));
                const auto path = folder / ("a" + std::to_string(number++));
                writeZarrArray(path, zarr, values);
                LabelFile file = openLabels(path, {});
                ASSERT_EQ(file.layers.size(), 1u);
                EXPECT_EQ(file.layers[0]->info().extentVoxels, glm::ivec3(13, 11, 7));
                EXPECT_EQ(readLayer(*file.layers[0]), values);
            }
    EXPECT_GT(number, 50);
}

TEST(ZarrLabels, EveryTypeKeepsItsValues) {
    const auto folder = labelTestFolder();
    const std::vector<std::pair<std::string, std::uint32_t>> types = {
        {"bool", 1},           {"int8", 127},         {"uint8", 255},         {"int16", 32767},
        {"uint16", 65535},     {"int32", 2147483647}, {"uint32", 4294967295}, {"int64", 4294967295},
        {"uint64", 4294967295}};
    for (const int version : {2, 3})
        for (const auto& [type, most] : types)
            for (const bool isBig : {false, true}) {
                WrittenZarr zarr;
                zarr.version = version;
                zarr.type = type;
                zarr.bigEndian = isBig;
                zarr.shape = kShape;
                zarr.chunk = {4, 4, 4};
                zarr.compressor = "blosc";
                const auto values = zarrLabelValues(7 * 11 * 13, most);
                const auto path = folder / (type + std::to_string(version) + std::to_string(isBig));
                writeZarrArray(path, zarr, values);
                EXPECT_EQ(readLayer(*openLabels(path, {}).layers[0]), values) << path;
            }
    WrittenZarr zarr;
    zarr.shape = zarr.chunk = {1, 1, 4};
    zarr.type = "int16";
    writeZarrArray(folder / "negative", zarr, {0, 0, 0, 65533});
    EXPECT_THAT(refusalOfReading(folder / "negative"), AllOf(HasSubstr("-3"), HasSubstr("(3, 0, 0)")));
    zarr.type = "uint64";
    writeZarrArray(folder / "wide", zarr, {0, 0, 0, 1});
    writeBytes(folder / "wide/c/0/0/0", std::string(28, '\0') + std::string("\1\0\0\0", 4));
    EXPECT_THAT(refusalOfReading(folder / "wide"), HasSubstr("4294967296"));
}

TEST(ZarrLabels, FillIsWhereThereIsNoChunk) {
    const auto folder = labelTestFolder();
    WrittenZarr zarr;
    zarr.shape = kShape;
    zarr.chunk = {3, 4, 5};
    zarr.fill = 9;
    std::vector<std::uint32_t> values(7 * 11 * 13, 9);
    values[500] = 4;
    for (const bool isSharded : {false, true}) {
        if (isSharded)
            zarr.shard = {3, 8, 5};
        writeZarrArray(folder / "a", zarr, values);
        EXPECT_EQ(readLayer(*openLabels(folder / "a", {}).layers[0]), values);
        std::filesystem::remove_all(folder / "a/c");
        const LabelFile file = openLabels(folder / "a", {});
        EXPECT_EQ(readLayer(*file.layers[0]), std::vector<std::uint32_t>(7 * 11 * 13, 9));
        EXPECT_THAT(file.layers[0]->notes(), testing::Contains(HasSubstr("27 of 27 chunks are not there")));
    }
}

TEST(ZarrLabels, TransformationsPlaceThem) {
    const auto folder = labelTestFolder();
    const auto values = zarrLabelValues(7 * 11 * 13);
    for (const int version : {2, 3}) {
        WrittenZarr zarr;
        zarr.version = version;
        zarr.shape = {1, 1, 7, 11, 13};
        zarr.chunk = {1, 2, 3, 4, 5};
        Json scales = multiscaleOf("tczyx", {1, 1, 4, 3, 2}, {0, 0, 30, 20, 10});
        scales["datasets"].insert(scales["datasets"].begin(),
                                  scales["datasets"][0]); // a coarser one in front
        scales["datasets"][0]["path"] = "missing";
        scales["datasets"][0]["coordinateTransformations"][0]["scale"] = {1, 1, 8, 6, 4};
        scales["coordinateTransformations"] =
            Json::array({Json{{"type", "scale"}, {"scale", {1, 1, 0.5, 0.5, 0.5}}},
                         Json{{"type", "translation"}, {"translation", {0, 0, 1, 0, 0}}}});
        const auto store = folder / ("s" + std::to_string(version));
        writeLabels(store, zarr, values, scales);
        for (const char* path : {"", "labels", "labels/cells"}) {
            LabelFile file = openLabels(store / path, {});
            const VolumeInfo& info = file.layers[0]->info();
            EXPECT_EQ(info.extentVoxels, glm::ivec3(13, 11, 7));
            EXPECT_EQ(info.spacingMm(), glm::dvec3(1, 1.5, 2));
            EXPECT_EQ(firstVoxelCentreMm(info), glm::dvec3(5, 10, 16));
            EXPECT_FALSE(info.orientationKnown);
            EXPECT_EQ(readLayer(*file.layers[0]), values);
        }
    }
}

TEST(ZarrLabels, AxesInAnyOrderWithUnitsAndOrientations) {
    const auto folder = labelTestFolder();
    const auto values = zarrLabelValues(7 * 11 * 13);
    Json scales = multiscaleOf("xyz", {4000, 3000, 2000}, {30000, 20000, 10000});
    for (Json& axis : scales["axes"])
        axis["unit"] = "micrometer";
    writeLabels(folder / "a", {}, values, scales);
    LabelFile plain = openLabels(folder / "a", {});
    // The fastest axis of the array is z.
    const glm::dmat4 affine = plain.layers[0]->info().patientFromVoxel;
    EXPECT_NEAR(affine[0].z, 2, 1e-12);
    EXPECT_NEAR(affine[1].y, 3, 1e-12);
    EXPECT_NEAR(affine[2].x, 4, 1e-12);
    const Places places = placesOf(*plain.layers[0]);
    const auto first = std::find_if(values.begin(), values.end(), [](auto value) { return value != 0; });
    const auto at = static_cast<long>(first - values.begin());
    EXPECT_EQ(places.at({3000 + 400 * (at / 143), 2000 + 300 * (at / 13 % 11), 1000 + 200 * (at % 13)}),
              *first);
    const char* const ways[] = {"left-to-right", "posterior-to-anterior", "inferior-to-superior"};
    for (std::size_t i = 0; i < 3; ++i)
        scales["axes"][i]["orientation"] = {{"type", "anatomical"}, {"value", ways[i]}};
    writeLabels(folder / "b", {}, values, scales);
    const VolumeInfo told = openLabels(folder / "b", {}).layers[0]->info();
    EXPECT_TRUE(told.orientationKnown);
    EXPECT_NEAR(told.patientFromVoxel[2].x, -4, 1e-12);
    EXPECT_NEAR(told.patientFromVoxel[1].y, -3, 1e-12);
    EXPECT_NEAR(glm::distance(firstVoxelCentreMm(told), glm::dvec3(-30, -20, 10)), 0, 1e-9);
}

TEST(ZarrLabels, NamesAndColours) {
    const auto folder = labelTestFolder();
    const Json about = {{"version", "0.4"},
                        {"colors", Json::array({Json{{"label-value", 0}, {"rgba", {0, 0, 0, 0}}},
                                                Json{{"label-value", 2}, {"rgba", {255, 128, 0, 255}}},
                                                Json{{"label-value", 40000}, {"rgba", {1, 2, 3, 4}}}})},
                        {"properties", Json::array({Json{{"label-value", 2}, {"area", 7}, {"name", "liver"}},
                                                    Json{{"label-value", 5}, {"class", "spleen"}},
                                                    Json{{"label-value", 6}, {"names", {"a", "b"}}}})},
                        {"source", {{"image", "../../"}}}};
    for (const int version : {2, 3}) {
        WrittenZarr zarr;
        zarr.version = version;
        writeLabels(folder / "a", zarr, zarrLabelValues(7 * 11 * 13),
                    multiscaleOf("zyx", {1, 1, 1}, {0, 0, 0}), "cells", about);
        const LabelFile file = openLabels(folder / "a", {});
        const glm::vec3 orange(linearFromSrgb(1), linearFromSrgb(128 / 255.0), 0);
        const glm::vec3 dark(linearFromSrgb(1 / 255.0), linearFromSrgb(2 / 255.0), linearFromSrgb(3 / 255.0));
        EXPECT_EQ(
            file.labels,
            (std::vector<Label>{
                {2, "liver", "", orange}, {5, "spleen"}, {6, "a, b"}, {40000, "label 40000", "", dark}}));
        EXPECT_THAT(file.notes, testing::Contains(HasSubstr("../../")));
        std::filesystem::remove_all(folder / "a");
    }
}

TEST(ZarrLabels, OneOfSeveralIsNamed) {
    const auto folder = labelTestFolder();
    const Json scales = multiscaleOf("zyx", {1, 1, 1}, {0, 0, 0});
    const auto values = zarrLabelValues(7 * 11 * 13);
    writeLabels(folder / "a.zarr", {}, values, scales, "organs");
    writeLabels(folder / "a.zarr", {}, values, scales, "vessels");
    writeZarrGroup(folder / "a.zarr/labels", 3, {{"labels", {"organs", "vessels"}}});
    for (const char* path : {"a.zarr", "a.zarr/", "a.zarr/labels"})
        EXPECT_THAT(refusalOf([&] { openLabels(folder / path, {}); }),
                    AllOf(HasSubstr("2 of them: organs, vessels"), HasSubstr("a.zarr/labels/organs")))
            << path;
    EXPECT_EQ(readLayer(*openLabels(folder / "a.zarr/labels/vessels", {}).layers[0]), values);
}

std::string nrrdTwin(const std::vector<std::uint32_t>& values) {
    return "NRRD0004\ntype: unsigned short\ndimension: 3\nspace: left-posterior-superior\nsizes: 13 11 7\n"
           "space directions: (2,0,0) (0,3,0) (0,0,4)\nkinds: domain domain domain\nendian: little\n"
           "encoding: raw\nspace origin: (10,20,30)\nSegment0_Name:=liver\nSegment0_LabelValue:=2\n"
           "Segment0_Color:=1 0.2 0\n\n" +
           fileBytes<std::uint16_t>(values);
}

/// The same labels as NRRD, on a lattice of their own and on that of a scan that is another.
TEST(ZarrLabels, TheTwinInNrrdGivesTheSameStore) {
    const auto folder = labelTestFolder();
    auto values = zarrLabelValues(7 * 11 * 13, 30);
    WrittenZarr zarr;
    zarr.compressor = "zstd";
    const Json about = {{"colors", Json::array({Json{{"label-value", 2}, {"rgba", {255, 51, 0, 255}}}})},
                        {"properties", Json::array({Json{{"label-value", 2}, {"name", "liver"}}})}};
    writeLabels(folder / "a.zarr", zarr, values, multiscaleOf("zyx", {4, 3, 2}, {30, 20, 10}), "cells",
                about);
    writeBytes(folder / "a.nrrd", nrrdTwin(values));
    const glm::dmat4 own = patientFromVoxelOf({10, 20, 30}, {2, 0, 0}, {0, 3, 0}, {0, 0, 4});
    const glm::dmat4 other = patientFromVoxelOf({11, 19, 31}, {1.7, 0.1, 0}, {0, 2.2, 0.2}, {0, 0, 5});
    for (const glm::dmat4& affine : {own, other}) {
        VolumeInfo scan = gridOf({13, 11, 7}, affine);
        for (const char* name : {"a.zarr", "a.nrrd"}) {
            LabelFile file = openLabels(folder / name, {});
            importAtFloor(file, scan, folder / (std::string(name) + ".store"));
        }
        const ReadBack a = readBack(folder / "a.zarr.store"), b = readBack(folder / "a.nrrd.store");
        EXPECT_EQ(a.levels, b.levels);
        EXPECT_EQ(a.table, b.table);
        std::filesystem::remove_all(folder / "a.zarr.store");
        std::filesystem::remove_all(folder / "a.nrrd.store");
    }
}

TEST(ZarrLabels, ABareArrayHasTheScansLattice) {
    const auto folder = labelTestFolder();
    const auto values = zarrLabelValues(7 * 11 * 13, 30);
    WrittenZarr zarr;
    zarr.shape = {1, 7, 11, 13};
    zarr.chunk = {1, 4, 4, 20};
    writeZarrArray(folder / "a", zarr, values);
    const VolumeInfo scan =
        gridOf({13, 11, 7}, patientFromVoxelOf({-90, 70, 31}, {0, 1.5, 0}, {0, 0, 2}, {0.5, 0, 0}));
    LabelFile file = openLabels(folder / "a", {});
    importAtFloor(file, scan, folder / "store");
    const ReadBack back = readBack(folder / "store");
    const auto sets = back.voxels();
    for (std::size_t i = 0; i < values.size(); ++i)
        ASSERT_EQ(sets[i], values[i] == 0 ? LabelSet{} : LabelSet{values[i]}) << i;
    LabelFile again = openLabels(folder / "a", {});
    EXPECT_THAT(refusalOf([&] {
                    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
                    importLabels(again, gridOf({13, 11, 8}, glm::dmat4(1)), folder / "no", ram, quickly());
                }),
                AllOf(HasSubstr("13x11x8"), HasSubstr("13x11x7")));
    EXPECT_FALSE(std::filesystem::exists(folder / "no"));
}

/// What OME-Zarr says of a tilted store is along straight axes; its labels are as tilted as it is.
TEST(ZarrLabels, InAStoreOfOursTheyAreWhereItsVolumeIs) {
    const auto folder = labelTestFolder();
    VolumeInfo info = gridOf(
        {13, 11, 7}, patientFromVoxelOf({10, 20, 30}, {1.9, 0.2, 0}, {-0.3, 2.9, 0.1}, {0.1, 0.4, 3.9}));
    info.type = ValueType::u16;
    const auto store = folder / "scan.zarr";
    {
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        StoreWriter writer(store, info, ram, 1, false);
        while (writer.nextSlices() > 0)
            writer.push();
        writer.finish(info, "");
        writer.commit(false);
    }
    const Json metadata = Json::parse(readBytes(store / "zarr.json"));
    const Json parent = metadata["attributes"]["ome"]["multiscales"][0];
    const auto values = zarrLabelValues(7 * 11 * 13);
    WrittenZarr zarr;
    zarr.shape = kShape;
    zarr.chunk = {7, 11, 13};
    writeZarrGroup(store / "labels", 3, {{"labels", {"organs"}}});
    writeZarrGroup(
        store / "labels/organs", 3,
        {{"version", "0.5"}, {"multiscales", Json::array({parent})}, {"image-label", Json::object()}});
    writeZarrArray(store / "labels/organs/0", zarr, values);
    const VolumeInfo found = openLabels(store, {}).layers[0]->info();
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row)
            EXPECT_NEAR(found.patientFromVoxel[column][row], info.patientFromVoxel[column][row], 1e-9);
}

/// Millimetres of a length of two units, and the ways of axes.
TEST(ZarrLabels, UnitsAndWaysOfAxes) {
    const auto folder = labelTestFolder();
    const auto values = zarrLabelValues(7 * 11 * 13);
    for (const auto& [unit, mm] : std::vector<std::pair<std::string, double>>{{"millimeter", 1},
                                                                              {"micrometer", 1e-3},
                                                                              {"nanometer", 1e-6},
                                                                              {"centimeter", 10},
                                                                              {"meter", 1000},
                                                                              {"decimeter", 100},
                                                                              {"angstrom", 1e-7},
                                                                              {"picometer", 1e-9},
                                                                              {"inch", 25.4}}) {
        const double each = mm < 1e-6 ? 2e4 : 2; // at least a nanometre a voxel
        Json scales = multiscaleOf("zyx", {4 * each, 3 * each, each}, {30, 20, 10});
        for (Json& axis : scales["axes"])
            axis["unit"] = unit;
        writeLabels(folder / unit, {}, values, scales);
        const VolumeInfo info = openLabels(folder / unit, {}).layers[0]->info();
        EXPECT_LT(glm::distance(info.spacingMm() / (mm * each), glm::dvec3(1, 3, 4)), 1e-9) << unit;
        EXPECT_LT(glm::distance(firstVoxelCentreMm(info) / mm, glm::dvec3(10, 20, 30)), 1e-6) << unit;
    }
    const std::array<std::array<const char*, 2>, 3> ways = {
        {{"right-to-left", "left-to-right"},
         {"anterior-to-posterior", "posterior-to-anterior"},
         {"inferior-to-superior", "superior-to-inferior"}}};
    std::array<std::size_t, 3> axes = {0, 1, 2};
    int number = 0;
    do
        for (std::size_t signs = 0; signs < 8; ++signs) {
            Json scales = multiscaleOf("zyx", {4, 3, 2}, {30, 20, 10});
            for (std::size_t i = 0; i < 3; ++i)
                scales["axes"][i]["orientation"] = {{"value", ways[axes[i]][signs >> i & 1]}};
            const auto store = folder / std::to_string(number++);
            writeLabels(store, {}, values, scales);
            const VolumeInfo info = openLabels(store, {}).layers[0]->info();
            EXPECT_TRUE(info.orientationKnown);
            for (std::size_t i = 0; i < 3; ++i) { // array axis i is voxel axis 2 - i
                glm::dvec3 expected(0), first(0);
                const double sign = (signs >> i & 1) != 0 ? -1 : 1;
                expected[static_cast<int>(axes[i])] = sign * (4.0 - static_cast<double>(i));
                EXPECT_LT(glm::distance(glm::dvec3(info.patientFromVoxel[static_cast<int>(2 - i)]), expected),
                          1e-12);
                EXPECT_NEAR(firstVoxelCentreMm(info)[static_cast<int>(axes[i])],
                            sign * (30 - 10.0 * static_cast<double>(i)), 1e-9);
            }
        }
    while (std::next_permutation(axes.begin(), axes.end()));
}

/// What zarr-python and zarrita wrote: 3x3x3 values from 0 to 26.
TEST(ZarrLabels, ArraysOfOtherPrograms) {
    if (testData().empty() || !std::filesystem::exists(testData() / "zarr-foreign"))
        GTEST_SKIP() << "no shared test data (TESSERA_TEST_DATA or ../shared/data)";
    const std::filesystem::path data = testData() / "zarr-foreign/zarrita";
    std::vector<std::uint32_t> values(27);
    std::iota(values.begin(), values.end(), 0u);
    for (const char* name :
         {"v2/data.zarr/3d.contiguous.i2", "v2/data.zarr/3d.chunked.i2", "v2/data.zarr/3d.chunked.mixed.i2.C",
          "v2/data.zarr/3d.chunked.mixed.i2.F", "v3/data.zarr/3d.chunked.i2",
          "v3/data.zarr/3d.chunked.mixed.i2.C", "v3/data.zarr/3d.chunked.mixed.i2.F",
          "v3/data.zarr/3d.contiguous.compressed.sharded.i2",
          "v3/data.zarr/3d.chunked.mixed.compressed.sharded.i2"})
        EXPECT_EQ(readLayer(*openLabels(data / name, {}).layers[0]), values) << name;
    EXPECT_THAT(refusalOfReading(data / "v2/data.zarr/3d.chunked.O"), HasSubstr("dtype"));
}

} // namespace
} // namespace tessera::test

// tests/bricking/import/files/vdb_grids_test.cpp: grids of OpenVDB files, against the library: every coding,
// level of the tree and transform; our own exports; what is no volume; damage.
#include "bricking/import/catalogue.h"
#include "bricking/import/files/vdb/vdb_values.h"
#include "bricking/import/source/half_floats.h"
#include "tests/support/export_tools.h"
#include "tests/support/import_test_tools.h"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <random>

namespace tessera::test {
namespace {

using openvdb::Coord;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

void writeGrids(const fs::path& path, const openvdb::GridPtrVec& grids, std::uint32_t compression) {
    openvdb::io::File file(path.string());
    file.setCompression(compression);
    file.write(grids);
    file.close();
}

float halved(float value, bool isHalf) {
    return isHalf ? static_cast<float>(openvdb::math::half(value)) : value;
}

/// Every voxel of the box of active ones has the value that the library gives.
void expectGrid(const fs::path& path, const openvdb::FloatGrid& grid, const std::string& what) {
    const auto source = openSource(path, {});
    const VolumeInfo& info = source->info();
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    ASSERT_EQ(info.extentVoxels, glm::ivec3(box.dim().x(), box.dim().y(), box.dim().z())) << what;
    const std::vector<float> read = readAll<float>(*source);
    openvdb::FloatGrid::ConstAccessor at = grid.getConstAccessor();
    std::size_t n = 0;
    for (int z = box.min().z(); z <= box.max().z(); ++z)
        for (int y = box.min().y(); y <= box.max().y(); ++y)
            for (int x = box.min().x(); x <= box.max().x(); ++x, ++n)
                ASSERT_EQ(read[n], halved(at.getValue(Coord(x, y, z)), grid.saveFloatAsHalf()))
                    << what << ": " << x << ' ' << y << ' ' << z;
}

/// Leaves with active and inactive values, at both sides of the origin, and tiles of leaves' size.
openvdb::FloatGrid::Ptr scatteredGrid(float background, int kinds, unsigned seed) {
    std::mt19937 random(seed);
    const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(background);
    openvdb::FloatGrid::Accessor at = grid->getAccessor();
    for (int leaf = 0; leaf < 9; ++leaf) {
        const Coord origin(8 * below(5) - 16, 8 * below(6) - 24, 8 * below(4) - 8);
        for (int i = 0; i < 200; ++i)
            at.setValue(origin + Coord(below(8), below(8), below(8)),
                        static_cast<float>(below(100)) * 0.25f - 9);
        // Inactive values: as many kinds as the coding tells apart.
        const float values[] = {-background, 3.5f, -7.25f, 11};
        for (int i = 0; i < 60 && kinds > 0; ++i)
            at.setValueOff(origin + Coord(below(8), below(8), below(8)), values[below(kinds)]);
    }
    // Leaves whose inactive values are one, or two, none of them the background.
    for (int n = 0; n < 512; ++n)
        for (const int leaf : {0, 1}) {
            const Coord place = Coord(32 + 8 * leaf, 0, 8) + Coord(n / 64, n / 8 % 8, n % 8);
            if (n % 5 == 0)
                at.setValue(place, static_cast<float>(n));
            else
                at.setValueOff(place, leaf == 1 && n % 3 == 0 ? 12.5f : 13.5f);
        }
    grid->tree().addTile(1, Coord(8, -40, 16), 6.5f, true);
    grid->tree().addTile(1, Coord(24, -40, 16), -2.5f, false);
    return grid;
}

TEST(ImportVdb, EveryCodingGivesTheLibrarysValues) {
    openvdb::initialize();
    const ScratchFolder folder;
    unsigned seed = 0;
    for (const std::uint32_t packing :
         {openvdb::io::COMPRESS_NONE + 0u, openvdb::io::COMPRESS_ZIP + 0u, openvdb::io::COMPRESS_BLOSC + 0u})
        for (const std::uint32_t mask : {0u, openvdb::io::COMPRESS_ACTIVE_MASK + 0u})
            for (const bool isHalf : {false, true})
                for (int kinds = 0; kinds <= 4; ++kinds) {
                    const openvdb::FloatGrid::Ptr grid = scatteredGrid(kinds % 2 ? 1.5f : 0, kinds, ++seed);
                    grid->setSaveFloatAsHalf(isHalf);
                    writeGrids(folder / "a.vdb", {grid}, packing | mask);
                    expectGrid(folder / "a.vdb", *grid,
                               std::to_string(packing | mask) + (isHalf ? " half " : " ") +
                                   std::to_string(kinds));
                }
}

// Tiles of 8, 128 and 4096 voxels, active and not.
TEST(ImportVdb, TilesOfEveryLevelAreFilled) {
    openvdb::initialize();
    const ScratchFolder folder;
    const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(-3);
    grid->tree().addTile(3, Coord(0, 0, 0), 5, false); // 4096
    grid->tree().setValue(Coord(-1, -1, -1), 1);
    grid->tree().setValue(Coord(4097, 2, 3), 2);
    writeGrids(folder / "a.vdb", {grid}, openvdb::io::COMPRESS_ACTIVE_MASK);
    expectGrid(folder / "a.vdb", *grid, "root");
    grid->clear();
    grid->tree().addTile(2, Coord(0, 128, 0), 7, true);
    grid->tree().addTile(2, Coord(128, 128, 0), 8, false);
    grid->tree().addTile(1, Coord(128, 0, 16), 9, false);
    grid->tree().setValue(Coord(260, 120, 130), 4);
    writeGrids(folder / "a.vdb", {grid}, openvdb::io::COMPRESS_ZIP);
    expectGrid(folder / "a.vdb", *grid, "128");
}

TEST(ImportVdb, HalvesAreTheFloatsOfIeee) {
    for (unsigned n = 0; n < 65536; ++n) {
        openvdb::math::half half;
        half.setBits(static_cast<std::uint16_t>(n));
        const float expected = half, found = floatOfHalf(static_cast<std::uint16_t>(n));
        ASSERT_TRUE(std::isnan(expected) ? std::isnan(found) : found == expected) << n;
        ASSERT_EQ(std::signbit(found), std::signbit(expected)) << n;
    }
}

TEST(ImportVdb, LinearTransformsPlaceTheVoxels) {
    openvdb::initialize();
    const ScratchFolder folder;
    using openvdb::math::Transform;
    openvdb::Mat4R sheared = openvdb::Mat4R::identity();
    sheared.setRow(0, openvdb::Vec4d(0.5, 0.1, 0, 0));
    sheared.setRow(1, openvdb::Vec4d(-0.1, 0.75, 0.05, 0));
    sheared.setRow(2, openvdb::Vec4d(0, 0.25, 1.25, 0));
    sheared.setRow(3, openvdb::Vec4d(10, -20, 30, 1));
    std::vector<Transform::Ptr> transforms = {Transform::createLinearTransform(0.25),    // UniformScaleMap
                                              Transform::createLinearTransform(sheared), // AffineMap
                                              Transform::createLinearTransform(1)};
    transforms.back()->postTranslate(openvdb::Vec3d(1, 2, 3)); // TranslationMap or with a scale
    for (const openvdb::Vec3d& scale : {openvdb::Vec3d(0.5, 0.75, 2), openvdb::Vec3d(-0.5, 0.75, 2)}) {
        transforms.push_back(Transform::createLinearTransform(1));
        transforms.back()->preScale(scale); // ScaleMap
        transforms.push_back(transforms.back()->copy());
        transforms.back()->postTranslate(openvdb::Vec3d(-7, 5, 3)); // ScaleTranslateMap
    }
    transforms.push_back(Transform::createLinearTransform(1));
    transforms.back()->preRotate(0.3, openvdb::math::X_AXIS);
    transforms.emplace_back(new Transform(
        openvdb::math::MapBase::Ptr(new openvdb::math::TranslationMap(openvdb::Vec3d(4, 5, 6)))));
    transforms.emplace_back(new Transform(
        openvdb::math::MapBase::Ptr(new openvdb::math::UnitaryMap(openvdb::Vec3d(1, 0, 0), 0.3))));
    std::set<std::string> maps;
    for (const Transform::Ptr& transform : transforms) {
        const openvdb::FloatGrid::Ptr grid = scatteredGrid(0, 0, 5);
        grid->setTransform(transform);
        writeGrids(folder / "a.vdb", {grid}, openvdb::io::COMPRESS_ZIP);
        const VolumeInfo info = openSource(folder / "a.vdb", {})->info();
        maps.insert(transform->mapType());
        EXPECT_FALSE(info.orientationKnown);
        EXPECT_THAT(info.remarks, Contains(HasSubstr("taken as LPS, mm")));
        const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
        // The volume's own order of axes: each corner of the box is a corner voxel.
        double nearest = 1e9;
        const openvdb::Vec3d corner = transform->indexToWorld(box.min());
        for (int n = 0; n < 8; ++n) {
            const glm::ivec3 last = info.extentVoxels - 1;
            nearest = std::min(nearest, glm::length(centreMm(info, n & 1 ? last.x : 0, n & 2 ? last.y : 0,
                                                             n & 4 ? last.z : 0) -
                                                    glm::dvec3(corner.x(), corner.y(), corner.z())));
        }
        EXPECT_LT(nearest, 1e-9) << transform->mapType();
        const openvdb::Vec3d size = transform->voxelSize();
        EXPECT_NEAR(info.spacingMm().x * info.spacingMm().y * info.spacingMm().z,
                    size.x() * size.y() * size.z(), 1e-9);
    }
    EXPECT_EQ(maps.size(), 5u) << "all that the library makes: " << ::testing::PrintToString(maps);
    const openvdb::FloatGrid::Ptr grid = scatteredGrid(0, 0, 5);
    grid->setTransform(Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(100)), 0.5, 10, 1));
    writeGrids(folder / "a.vdb", {grid}, openvdb::io::COMPRESS_ZIP);
    EXPECT_THAT(refusalOfOpening(folder / "a.vdb"),
                AllOf(HasSubstr("a.vdb"), HasSubstr("NonlinearFrustumMap")));
}

TEST(ImportVdb, LevelSetsAreDistancesInTheirBand) {
    openvdb::initialize();
    const ScratchFolder folder;
    const auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(20, {5, 0, -3}, 1, 3);
    writeGrids(folder / "a.vdb", {grid}, openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC);
    expectGrid(folder / "a.vdb", *grid, "sphere");
    const auto source = openSource(folder / "a.vdb", {});
    EXPECT_THAT(source->describe(), AllOf(HasSubstr("level set"), HasSubstr("narrow band of 3 ")));
    EXPECT_EQ(source->info().fillStored, 3);
}

// Margins of the lowest value too, which are background in the file.
TEST(ImportVdb, ExportsComeBackAsTheyWere) {
    forEachStoreToExport([](const StoreReader& store, const ScratchFolder& scratch, ValueType type) {
        for (const LevelBox& box : boxesFor(store.info())) {
            exportBox("vdb", store, box, scratch / "v.vdb", box.level == 2);
            const auto source = openSource(scratch / "v.vdb", {});
            const VolumeInfo& info = source->info();
            ASSERT_EQ(info.extentVoxels, box.extent());
            EXPECT_EQ(info.unit, store.info().unit);
            EXPECT_EQ(info.orientationKnown, store.info().orientationKnown);
            EXPECT_TRUE(info.remarks.empty());
            expectPlace(store.info(), box, fourCentres(info), 1e-15, "vdb");
            const std::vector<double> expected = expectedValues(store, box);
            EXPECT_EQ(readAll<float>(*source), std::vector<float>(expected.begin(), expected.end()))
                << name(type) << box.level;
        }
    });
    const ScratchFolder scratch;
    HashSource source(plainInfo({40, 30, 20}, ValueType::u8), [](int x, int y, int z) {
        return x > 9 && x < 30 && y > 8 && z > 3 && z < 12 ? 5.0 + x % 3 : 2.0;
    });
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    for (const char* format : {"vdb", "vdb-half"}) {
        exportBox(format, store, wholeLevel(store.info(), 0), scratch / "v.vdb");
        const auto read = openSource(scratch / "v.vdb", {});
        EXPECT_EQ(read->info().extentVoxels, glm::ivec3(40, 30, 20));
        const std::vector<double> expected = expectedValues(store, wholeLevel(store.info(), 0));
        EXPECT_EQ(readAll<float>(*read), std::vector<float>(expected.begin(), expected.end())) << format;
    }
}

std::string bytesOfFile(const fs::path& path) {
    std::string bytes(fs::file_size(path), '\0');
    std::ifstream(path, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return bytes;
}

TEST(ImportVdb, WhatIsNoVolumeIsRefusedByItsName) {
    openvdb::initialize();
    const ScratchFolder folder;
    const auto named = [](openvdb::GridBase::Ptr grid, const char* name) {
        grid->setName(name);
        return grid;
    };
    const auto expectRefusal = [&](const openvdb::GridPtrVec& grids, const char* what) {
        writeGrids(folder / "a.vdb", grids, openvdb::io::COMPRESS_ZIP);
        EXPECT_THAT(refusalOfOpening(folder / "a.vdb"), AllOf(HasSubstr("a.vdb"), HasSubstr(what)));
    };
    const auto density = named(scatteredGrid(0, 0, 1), "density"),
               heat = named(scatteredGrid(0, 0, 2), "heat"),
               speed = named(openvdb::Vec3SGrid::create(), "speed"),
               ids = named(openvdb::Int32Grid::create(), "ids");
    expectRefusal({density, heat, speed}, "2 volumes");
    SourceOptions second;
    second.series = 2;
    EXPECT_EQ(lookThrough(folder / "a.vdb").rows.at(1).what, "\"heat\"");
    EXPECT_EQ(readAll<float>(*openSource(folder / "a.vdb", second)), [&] {
        const ScratchFolder alone;
        writeGrids(alone / "b.vdb", {heat}, openvdb::io::COMPRESS_ZIP);
        return readAll<float>(*openSource(alone / "b.vdb", {}));
    }());
    expectRefusal({speed, ids}, "\"ids\" (\"Tree_int32_5_4_3\")");
    expectRefusal({named(openvdb::DoubleGrid::create(), "d")}, "Tree_double_5_4_3");
    expectRefusal({openvdb::FloatGrid::create()}, "none");
    expectRefusal({}, "no grid");
    writeGrids(folder / "a.vdb", {speed, density, ids}, openvdb::io::COMPRESS_ZIP);
    EXPECT_THAT(openSource(folder / "a.vdb", {})->info().remarks, Contains(HasSubstr("are left out: 2")));
    expectGrid(folder / "a.vdb", dynamic_cast<openvdb::FloatGrid&>(*density), "beside others");
    // What a file says of its active voxels is compared with them.
    const std::string whole = [&] {
        writeGrids(folder / "a.vdb", {density}, openvdb::io::COMPRESS_ZIP);
        return bytesOfFile(folder / "a.vdb");
    }();
    for (const char* said : {"file_bbox_min", "file_bbox_max", "file_voxel_count"}) {
        std::string bytes = whole;
        bytes[bytes.find(said) + std::string(said).size() + 13] ^= 1; // behind its type and length
        writeFile(folder / "a.vdb", bytes);
        EXPECT_THAT(refusalOfOpening(folder / "a.vdb"), HasSubstr(said)) << said;
    }
    // The leaves end with the grid.
    std::string longer = whole + "x";
    const std::size_t end = longer.find("Tree_float_5_4_3") + 16 + 4 + 2 * 8; // behind a name and two places
    ++longer[end];
    writeFile(folder / "a.vdb", longer);
    EXPECT_THAT(refusal([&] { readAll<float>(*openSource(folder / "a.vdb", {})); }),
                AllOf(HasSubstr("a.vdb"), HasSubstr("up to the end of the grid, found 1 bytes more")));
    // Two voxels that are far apart: nothing of that size is allocated.
    const auto far = openvdb::FloatGrid::create();
    far->tree().setValue(Coord(-500'000'000, 0, 0), 1);
    far->tree().setValue(Coord(500'000'000, 500'000'000, 500'000'000), 1);
    expectRefusal({far}, "fills to a 16384th");
    std::ofstream out(folder / "a.vdb", std::ios::binary);
    openvdb::io::Stream(out).write(openvdb::GridCPtrVec{density});
    out.close();
    EXPECT_THAT(refusalOfOpening(folder / "a.vdb"), HasSubstr("a stream of grids"));
    writeFile(folder / "a.vdb", "");
    EXPECT_THAT(refusalOfOpening(folder / "a.vdb"), HasSubstr("an empty file"));
}

/// Read, or refused by an InputError that names the file.
void expectReadOrNamed(const fs::path& path) {
    try {
        const auto source = openSource(path, {});
        ASSERT_LT(source->info().voxelCount(), std::uint64_t{1} << 28);
        if (source->info().voxelCount() < 1u << 20)
            readAll<float>(*source);
    } catch (const InputError& error) {
        ASSERT_THAT(error.what(), HasSubstr(path.filename().string()));
    }
}

TEST(ImportVdb, CutAndDamagedFilesAreErrorsOrRead) {
    openvdb::initialize();
    const ScratchFolder folder;
    for (const std::uint32_t packing : {2u, 3u, 6u}) { // none, zip, blosc, without inactive values
        const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(0.5f);
        std::mt19937 random(4711);
        for (int i = 0; i < 900; ++i)
            grid->tree().setValue(Coord(static_cast<int>(random() % 16), static_cast<int>(random() % 8), 3),
                                  static_cast<float>(random() % 50));
        writeGrids(folder / "w.vdb", {grid}, packing);
        const std::string whole = bytesOfFile(folder / "w.vdb");
        for (std::size_t n = 0; n < whole.size(); n += 1 + whole.size() / 700) {
            writeFile(folder / "a.vdb", whole.substr(0, n));
            ASSERT_THAT(refusalOfOpening(folder / "a.vdb"), HasSubstr("a.vdb")) << n;
        }
        // Half of the hits in the header, or in the masks and values at the end.
        const std::size_t header = whole.find("Tree_float") + 700, leaves = whole.size() - 1200;
        for (int n = 0; n < 900; ++n) {
            std::string bytes = whole;
            for (std::size_t i = 0; i < 1 + random() % 2; ++i) {
                const std::size_t at = n % 3 == 0   ? random() % header
                                       : n % 3 == 1 ? leaves + random() % (whole.size() - leaves)
                                                    : random() % whole.size();
                bytes[at] = static_cast<char>(n % 2 ? random() : bytes[at] ^ (1 << random() % 8));
            }
            writeFile(folder / "a.vdb", bytes);
            expectReadOrNamed(folder / "a.vdb");
        }
    }
}

} // namespace
} // namespace tessera::test

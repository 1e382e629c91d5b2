// tests/bricking/import/files/vgi_test.cpp: Volume Graphics volumes with headers as several programs write
// them: types, places, reversed axes, and every lie refused.
#include "tests/support/import_test_tools.h"

#include <glm/geometric.hpp>
#include <gmock/gmock.h>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

struct Vgi {
    std::string file = "SkipHeader = 0\nFileFormat = raw\nSize = 3 4 5\nName = a.vol\n"
                       "Datatype = signed integer\ndatarange = 0 -1\nBitsPerElement = 16\n";
    std::string held = "size = 3 4 5\ndatatype = signed integer\nbitsperelement = 16\n";
    std::string geometry = "resolution = 0.5 0.75 1.25\nunit = mm\n";
    std::string more = "";

    std::string text() const {
        return "{volume1}\n[representation]\n" + held + "[file1]\n" + file +
               "{volumeprimitive12}\n[geometry]\n" + geometry +
               "[volume]\nvolume = volume1\n[description]\ntext = a scan\n" + more;
    }
};

/// Of 3 x 4 x 5 voxels.
template <class T> std::vector<T> vgiVoxels() {
    std::vector<T> values(60);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<T>(i * i);
    values[7] = std::numeric_limits<T>::max();
    values[8] = std::numeric_limits<T>::lowest();
    return values;
}

template <class In, class Out> void expectVgiType(const std::string& words) {
    const ScratchFolder folder;
    const std::vector<In> values = vgiVoxels<In>();
    writeFile(folder / "a.vol", "123456" + voxelBytes(values));
    Vgi vgi;
    vgi.file = "SkipHeader = 6\nFileFormat = raw\nSize = 3 4 5\nName = a.vol\nDatatype = " + words +
               "\nBitsPerElement = " + std::to_string(8 * sizeof(In)) + "\n";
    vgi.held = "size = 3 4 5\ndatatype = float\nbitsperelement = 32\n"; // as a program would hold it
    writeFile(folder / "a.vgi", vgi.text());
    const auto source = openSource(folder / "a.vgi", {});
    EXPECT_EQ(source->info().spacingMm(), glm::dvec3(0.5, 0.75, 1.25));
    EXPECT_FALSE(source->info().orientationKnown);
    EXPECT_THAT(source->info().remarks, IsEmpty());
    EXPECT_EQ(readAll<Out>(*source), std::vector<Out>(values.begin(), values.end())) << words;
}

TEST(ImportVgi, EveryTypeReadsBackEqual) {
    expectVgiType<std::uint8_t, std::uint8_t>("unsigned integer");
    expectVgiType<std::uint16_t, std::uint16_t>("unsigned integer");
    expectVgiType<std::uint32_t, float>("Unsigned Integer");
    expectVgiType<std::int8_t, std::int16_t>("signed integer");
    expectVgiType<std::int16_t, std::int16_t>("signed integer");
    expectVgiType<std::int32_t, float>("signed integer");
    expectVgiType<float, float>("float");
}

// What the file does not say is that of the whole volume.
TEST(ImportVgi, TheVolumeSpeaksWhereTheFileIsSilent) {
    const ScratchFolder folder;
    writeFile(folder / "a.vol", voxelBytes(vgiVoxels<std::int16_t>()));
    Vgi vgi;
    vgi.file = "Name = a.vol\n";
    writeFile(folder / "a.vgi", vgi.text());
    EXPECT_EQ(readAll<std::int16_t>(*openSource(folder / "a.vgi", {})), vgiVoxels<std::int16_t>());
}

// A header of phoenix datos|x, shortened: a name of another machine, reversed axes, a scene.
TEST(ImportVgi, HeadersOfScannersAreRead) {
    const ScratchFolder folder;
    const std::vector<std::uint16_t> values = vgiVoxels<std::uint16_t>();
    writeFile(folder / "scan 2.vol", voxelBytes(values));
    writeFile(
        folder / "scan 2.vgi",
        "{volume1}\r\n[representation]\r\nsize = 3 4 5\r\nmirror = 0 0 0 0 \r\nbitsperelement = 16\r\n"
        "datatype = unsigned integer\r\ndatarange = 0 65535\r\n[file1]\r\nMirror = 0 1 1\r\n"
        "RegionOfInterestStart = 0 0 0\r\nRegionOfInterestEnd   = 2 3 4\r\nFileFormat = raw\r\n"
        "Size = 3 4 5\r\nName = X:\\24 08\\scan 2\\scan 2.vol\r\nbitsperelement = 16\r\n"
        "datatype = unsigned integer\r\ndatarange = 0 65535\r\n[description]\r\ntext = 0\r\n{default}\r\n"
        "[version]\r\nrelease = VGStudioMax 1.0\r\n{volumeprimitive9}\r\n[section1]\r\nmax = 65535\r\n"
        "[geometry]\r\nclipplane1 = -1 0 0 1737\r\nposition = 10.5 -38 0\r\nresolution = 50 50 60\r\n"
        "scale = 1 1 1\r\nrotate = 1 0 0 0 1 0 0 0 1\r\nunit = um\r\n[volume]\r\nvolume = volume1\r\n");
    const auto source = openSource(folder.path(), {}); // the only volume of the folder
    const VolumeInfo& info = source->info();
    EXPECT_LT(glm::length(info.spacingMm() - glm::dvec3(0.05, 0.05, 0.06)), 1e-12);
    const std::vector<std::uint16_t> read = readAll<std::uint16_t>(*source);
    for (int z = 0; z < 5; ++z)
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 3; ++x)
                ASSERT_EQ(read[indexOf(info, x, y, z)], values[indexOf(info, x, 3 - y, 4 - z)]);
}

TEST(ImportVgi, ReversedAxesGiveEveryVoxelItsPlace) {
    const ScratchFolder folder;
    const std::vector<std::int16_t> values = vgiVoxels<std::int16_t>();
    writeFile(folder / "a.vol", voxelBytes(values));
    for (int signs = 0; signs < 8; ++signs) {
        const glm::ivec3 is(signs & 1, signs >> 1 & 1, signs >> 2 & 1);
        Vgi vgi;
        vgi.file += "Mirror = " + std::to_string(is.x) + " " + std::to_string(is.y) + " " +
                    std::to_string(is.z) + "\n";
        writeFile(folder / "a.vgi", vgi.text());
        const auto source = openSource(folder / "a.vgi", {});
        const VolumeInfo info = source->info();
        EXPECT_LT(glm::length(centreMm(info, 2, 3, 4) - centreMm(info, 0, 0, 0) - glm::dvec3(1, 2.25, 5)),
                  1e-9);
        const std::vector<std::int16_t> read = readAll<std::int16_t>(*source);
        for (int z = 0; z < 5; ++z)
            for (int y = 0; y < 4; ++y)
                for (int x = 0; x < 3; ++x)
                    ASSERT_EQ(read[indexOf(info, x, y, z)],
                              values[indexOf(info, is.x ? 2 - x : x, is.y ? 3 - y : y, is.z ? 4 - z : z)])
                        << signs;
    }
}

TEST(ImportVgi, AnUnknownSpacingIsAskedFor) {
    const ScratchFolder folder;
    writeFile(folder / "a.vol", voxelBytes(vgiVoxels<std::int16_t>()));
    const auto write = [&](const std::string& geometry) {
        writeFile(folder / "a.vgi", Vgi{.geometry = geometry}.text());
        return folder / "a.vgi";
    };
    EXPECT_THAT(refusalOfOpening(write("resolution = 1 2 3\n")), HasSubstr("--spacing X,Y,Z"));
    EXPECT_THAT(refusalOfOpening(write("unit = mm\n")), HasSubstr("--spacing X,Y,Z"));
    EXPECT_EQ(
        openSource(write("resolution = 1 2 3\n"), {.spacingMm = glm::dvec3(2, 5, 7)})->info().spacingMm(),
        glm::dvec3(2, 5, 7));
    EXPECT_THAT(refusalOfOpening(write("resolution = 1 2 3\nunit = cm\n"), {.spacingMm = glm::dvec3(1)}),
                HasSubstr("one that does"));
    EXPECT_EQ(openSource(write("resolution = 1 2 3\nunit = cm\n"), {})->info().spacingMm(),
              glm::dvec3(10, 20, 30));
}

TEST(ImportVgi, WhatIsNotUnderstoodIsRefusedOrSaid) {
    const ScratchFolder folder;
    writeFile(folder / "a.vol", voxelBytes(vgiVoxels<std::int16_t>()));
    const Vgi good;
    const auto expectRefusal = [&](const Vgi& vgi, const char* what) {
        writeFile(folder / "a.vgi", vgi.text());
        EXPECT_THAT(refusalOfOpening(folder / "a.vgi"), AllOf(HasSubstr("a.vgi"), HasSubstr(what)));
    };
    const auto withFile = [&](const std::string& more) {
        Vgi vgi;
        vgi.file += more;
        return vgi;
    };
    const auto withGeometry = [&](const std::string& more) {
        Vgi vgi;
        vgi.geometry += more;
        return vgi;
    };
    expectRefusal({.more = "{volume2}\n[file1]\nName = b.vol\n"}, "several: \"volume1\", \"volume2\"");
    expectRefusal(withFile("[file2]\nName = b.vol\n"), "several: \"file1\", \"file2\"");
    expectRefusal(withFile("RegionOfInterestStart = 0 1 0\n"), "whole file of 3 4 5 voxels");
    expectRefusal(withFile("RegionOfInterestEnd = 2 3 3\n"), "whole file of 3 4 5 voxels");
    expectRefusal({.held = "size = 3 4 4\n"}, "whole file of 3 4 5 voxels");
    expectRefusal({.held = "mirror = 1 0 0 0\n"}, "of the file alone");
    expectRefusal(withFile("Mirror = 0 2 0\n"), "0 or 1");
    expectRefusal(withFile("Size = 3 5 4\n"), "\"size\" again");
    expectRefusal(withFile("ByteOrder = big\n"), "little endian");
    expectRefusal(withGeometry("scale = 2 1 1\n"), "scale = 1 1 1");
    expectRefusal({.more = "{volumeprimitive13}\n[geometry]\nresolution = 1 1 1\nunit = mm\n"
                           "[volume]\nvolume = volume1\n"},
                  "one \"resolution\"");
    expectRefusal({.geometry = "resolution = 1 0 1\nunit = mm\n"}, "above 0");
    expectRefusal({.geometry = "resolution = 1 nan 1\nunit = mm\n"}, "finite");
    expectRefusal({.geometry = "resolution = 1 1 1e9\nunit = mm\n"}, "\"resolution\"");
    expectRefusal({.geometry = "resolution = 1 1 1\nunit = furlong\n"}, "furlong");
    const auto withRow = [&](const std::string& from, const std::string& to) {
        Vgi vgi;
        vgi.file.replace(vgi.file.find(from), from.size(), to);
        vgi.held = "";
        return vgi;
    };
    expectRefusal(withRow("raw", "jpg"), "jpg");
    expectRefusal(withRow("signed integer", "complex"), "complex");
    expectRefusal(withRow("BitsPerElement = 16", "BitsPerElement = 12"), "\"12\" bits");
    expectRefusal(withRow("BitsPerElement = 16\n", ""), "bitsperelement");
    expectRefusal(withRow("Size = 3 4 5", "Size = 3 4"), "of 3 numbers");
    expectRefusal(withRow("Size = 3 4 5", "Size = 3 4 0"), "at least 1");
    expectRefusal(withRow("Size = 3 4 5", "Size = 3 4 5.5"), "whole numbers");
    expectRefusal(withRow("Size = 3 4 5", "Size = 2000000000 2000000000 2000000000"), "2^58");
    expectRefusal(withRow("SkipHeader = 0", "SkipHeader = -1"), "SkipHeader");
    expectRefusal(withRow("a.vol", "../a.vol"), "below the header's folder");
    expectRefusal(withRow("a.vol", "sub\\"), "\"Name\"");
    writeFile(folder / "a.vgi", "hello = world\n");
    EXPECT_THAT(refusalOfOpening(folder / "a.vgi"), HasSubstr("begins with {volume1}"));
    // Lengths of the voxels: their file is named.
    const auto expectOfData = [&](const Vgi& vgi, const char* what) {
        writeFile(folder / "a.vgi", vgi.text());
        EXPECT_THAT(refusalOfOpening(folder / "a.vgi"), AllOf(HasSubstr("a.vol"), HasSubstr(what)));
    };
    expectOfData(withRow("Size = 3 4 5", "Size = 3 4 6"), "too short");
    expectOfData(withRow("Size = 3 4 5", "Size = 2000000 2000000 1000"), "too short");
    expectOfData(withRow("Size = 3 4 5", "Size = 3 4 4"), "24 bytes more");
    expectOfData(withRow("SkipHeader = 0", "SkipHeader = 9007199254740992"), "too short");
    fs::rename(folder / "a.vol", folder / "b.vol");
    expectOfData(good, "a.vol");
    EXPECT_THAT(refusalOfOpening(folder / "b.vol"), HasSubstr("open its header (.vgi)"));
    fs::rename(folder / "b.vol", folder / "a.vol");
    writeFile(folder / "a.vgi", withFile("Gain = 3\n").text());
    EXPECT_THAT(openSource(folder / "a.vgi", {})->info().remarks, Contains(HasSubstr("\"gain\"")));
    writeFile(folder / "a.vgi", withGeometry("rotate = 0 1 0 -1 0 0 0 0 1\n").text());
    EXPECT_THAT(openSource(folder / "a.vgi", {})->info().remarks, Contains(HasSubstr("rotate")));
    // Another volume's geometry does not matter.
    writeFile(folder / "a.vgi", Vgi{.more = "{volumeprimitive13}\n[geometry]\nresolution = 1 1 1\nunit = mm\n"
                                            "[volume]\nvolume = volume2\n"}
                                    .text());
    EXPECT_EQ(openSource(folder / "a.vgi", {})->info().spacingMm(), glm::dvec3(0.5, 0.75, 1.25));
}

TEST(ImportVgi, TruncationAndRandomDamageAreErrorsOrRead) {
    const ScratchFolder folder;
    const std::vector<std::int16_t> values = vgiVoxels<std::int16_t>();
    writeFile(folder / "a.vol", voxelBytes(values));
    const std::string whole = Vgi().text();
    const std::size_t placed = whole.find("unit = mm\n") + 10; // all that is read, but whose geometry it is
    for (std::size_t n = 0; n < whole.size(); ++n) {
        writeFile(folder / "a.vgi", whole.substr(0, n));
        if (n < placed) {
            ASSERT_THAT(refusalOfOpening(folder / "a.vgi"), HasSubstr("a.vgi")) << n;
            continue;
        }
        try {
            const auto source = openSource(folder / "a.vgi", {});
            EXPECT_EQ(source->info().spacingMm(), glm::dvec3(0.5, 0.75, 1.25));
            EXPECT_EQ(readAll<std::int16_t>(*source), values);
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr("a.vgi")) << n;
        }
    }
    expectDamageHarmless(folder / "a.vgi", whole, whole.size());
    writeFile(folder / "a.vgi", whole);
    const std::string data = voxelBytes(values);
    for (const std::size_t n : {std::size_t{0}, std::size_t{1}, data.size() - 1}) {
        writeFile(folder / "a.vol", data.substr(0, n));
        EXPECT_THAT(refusalOfOpening(folder / "a.vgi"), HasSubstr("a.vol")) << n;
    }
}

} // namespace
} // namespace tessera::test

// tests/bricking/import/files/nrrd_test.cpp: volumes in NRRD files that the test writes: types, codings,
// places, VTK's reader as a second one, and every lie refused.
#include "bricking/import/catalogue.h"
#include "tests/support/import_test_tools.h"
#include "tests/support/vtk_volume.h"

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <vtkNrrdReader.h>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

const std::string kNrrdPlace = "space: left-posterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
                               "space origin: (10,20,30)\n";

std::string nrrdHeader(const std::string& type, const std::string& encoding,
                       const std::string& more = kNrrdPlace, const std::string& sizes = "3 4 5") {
    const auto axes = std::count(sizes.begin(), sizes.end(), ' ') + 1;
    return "NRRD0005\ntype: " + type + "\ndimension: " + std::to_string(axes) + "\nsizes: " + sizes +
           "\nencoding: " + encoding + "\n" + more;
}

/// 60 values, the extremes of the type among them.
template <class T> std::vector<T> nrrdVoxels() {
    std::vector<T> values(60);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<T>(static_cast<double>(i * i) * 0.5 - 40);
    values[7] = std::numeric_limits<T>::max();
    values[8] = std::numeric_limits<T>::lowest();
    return values;
}

template <class In, class Out> void expectNrrdCodings(const std::string& type) {
    const ScratchFolder folder;
    const std::vector<In> values = nrrdVoxels<In>();
    const std::vector<Out> expected(values.begin(), values.end());
    for (const bool big : {false, true})
        for (const bool packed : {false, true})
            for (const bool detached : {false, true}) {
                const std::string data = voxelBytes(values, big);
                const std::string header =
                    nrrdHeader(type, packed ? "gzip" : "raw",
                               kNrrdPlace + "endian: " + (big ? "big" : "little") + "\n", "5 4 3");
                const fs::path path = folder / (detached ? "a.nhdr" : "a.nrrd");
                if (detached)
                    writeFile(folder / "a.dat", packed ? gzip(data) : data);
                writeFile(path, detached ? header + "data file: a.dat\n"
                                         : header + "\n" + (packed ? gzip(data) : data));
                const auto source = openSource(path, {});
                EXPECT_EQ(source->info().extentVoxels, glm::ivec3(5, 4, 3));
                EXPECT_EQ(readAll<Out>(*source), expected) << type << big << packed << detached;
                if constexpr (std::is_same_v<In, Out>) {
                    if (!packed) { // VTK 9.1 reads some packed data from a wrong byte on, and in one order
                        EXPECT_EQ((vtkVoxels<Out, vtkNrrdReader>(path)), expected)
                            << "VTK " << type << big << packed;
                    }
                }
            }
}

TEST(ImportNrrd, EveryTypeAndCodingReadsBackEqual) {
    expectNrrdCodings<std::int8_t, std::int16_t>("signed char");
    expectNrrdCodings<std::uint8_t, std::uint8_t>("uchar");
    expectNrrdCodings<std::int16_t, std::int16_t>("short");
    expectNrrdCodings<std::uint16_t, std::uint16_t>("unsigned short");
    expectNrrdCodings<float, float>("float");
}

TEST(ImportNrrd, LongNumbersBecomeFloatsAndAreCounted) {
    const ScratchFolder folder;
    writeFile(folder / "a.nrrd", nrrdHeader("int", "raw", kNrrdPlace + "endian: little\n", "3 1 1") + "\n" +
                                     voxelBytes<std::int32_t>({5, (1 << 24) + 1, -7}));
    const auto source = openSource(folder / "a.nrrd", {});
    EXPECT_THAT(source->describe(), HasSubstr("converted to float32"));
    EXPECT_EQ(readAll<float>(*source), (std::vector<float>{5, 1 << 24, -7}));
    EXPECT_THAT(source->takeTally().notes(), testing::Contains(HasSubstr("1 whole numbers beyond 2^24")));
}

TEST(ImportNrrd, DoublesThatFloatCannotHoldAreToldOf) {
    const ScratchFolder folder;
    writeFile(folder / "a.nrrd", nrrdHeader("double", "raw", kNrrdPlace + "endian: big\n", "3 1 1") + "\n" +
                                     voxelBytes<double>({5, 0.1, -7}, true));
    const auto source = openSource(folder / "a.nrrd", {});
    readAll<float>(*source);
    EXPECT_THAT(source->takeTally().notes(), testing::Contains(HasSubstr("which changed 1 of them")));
}

/// Plain and packed data, axes that run the other way or change places, numbers that are converted, few
/// values.
TEST(ImportNrrd, RowsAreThoseOfSlices) {
    const ScratchFolder folder;
    std::vector<float> numbers(7 * 50 * 6);
    for (std::size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = static_cast<float>(i % 5 + i / 700);
    std::vector<float> holes = numbers;
    holes[3] = holes[1000] = std::nanf("");
    const std::vector<std::uint16_t> whole(numbers.begin(), numbers.end());
    const auto expectRows = [&](const std::string& name, const std::string& text, RowAccess expected) {
        SCOPED_TRACE(name);
        writeFile(folder / "a.nrrd", text);
        expectRowsOfSlices([&] { return openSource(folder / "a.nrrd", {}); }, expected);
    };
    struct Axes {
        const char *directions, *name;
        RowAccess plain, packed;
    };
    for (const Axes& axes :
         {Axes{"(2,0,0) (0,3,0) (0,0,4)", "as they are", RowAccess::any, RowAccess::inOrder},
          Axes{"(-2,0,0) (0,3,0) (0,0,4)", "x turned", RowAccess::any, RowAccess::inOrder},
          Axes{"(-2,0,0) (0,-3,0) (0,0,-4)", "all turned", RowAccess::any, RowAccess::none},
          Axes{"(0,3,0) (2,0,0) (0,0,4)", "exchanged", RowAccess::none, RowAccess::none}}) {
        const std::string place = std::string("space: left-posterior-superior\nspace directions: ") +
                                  axes.directions + "\nspace origin: (0,0,0)\n";
        for (const bool packed : {false, true})
            for (const bool big : {false, true}) {
                const RowAccess access = packed ? axes.packed : axes.plain;
                if (access == RowAccess::none) {
                    writeFile(folder / "a.nrrd", nrrdHeader("ushort", packed ? "gzip" : "raw",
                                                            place + "endian: little\n", "7 50 6") +
                                                     "\n" +
                                                     (packed ? gzip(voxelBytes(whole)) : voxelBytes(whole)));
                    EXPECT_EQ(openSource(folder / "a.nrrd", {})->rowAccess(), access);
                    continue;
                }
                const auto file = [&](const char* type, const std::string& data) {
                    return nrrdHeader(type, packed ? "gzip" : "raw",
                                      place + "endian: " + (big ? "big" : "little") + "\n", "7 50 6") +
                           "\n" + (packed ? gzip(data) : data);
                };
                expectRows(axes.name, file("ushort", voxelBytes(whole, big)), access);
                expectRows(axes.name, file("float", voxelBytes(holes, big)), access);
            }
    }
}

TEST(ImportNrrd, DataInManyFiles) {
    const ScratchFolder folder;
    const std::vector<std::uint16_t> values = nrrdVoxels<std::uint16_t>();
    const std::string data = voxelBytes(values),
                      head = nrrdHeader("ushort", "raw", kNrrdPlace + "endian: little\n"),
                      packedHead = nrrdHeader("ushort", "gzip", kNrrdPlace + "endian: little\n");
    for (const bool packed : {false, true}) {
        for (std::size_t z = 0; z < 5; ++z)
            writeFile(folder / ("s" + std::to_string(9 + z) + ".dat"),
                      packed ? gzip(data.substr(24 * z, 24)) : data.substr(24 * z, 24));
        const std::string& header = packed ? packedHead : head;
        writeFile(folder / "list.nhdr",
                  header + "data file: LIST\ns9.dat\ns10.dat\ns11.dat\ns12.dat\ns13.dat\n");
        writeFile(folder / "pattern.nhdr", header + "data file: s%d.dat 9 13 1\n");
        for (const char* name : {"list.nhdr", "pattern.nhdr"})
            EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder / name, {})), values) << name << packed;
    }
    const auto writeSlices = [&](std::size_t shorter) {
        for (std::size_t z = 0; z < 5; ++z)
            writeFile(folder / ("s" + std::to_string(9 + z) + ".dat"),
                      data.substr(24 * z, z == shorter ? 23 : 24));
    };
    writeSlices(5);
    writeFile(folder / "list.nhdr", head + "data file: LIST\ns9.dat\ns10.dat\ns11.dat\ns12.dat\n");
    EXPECT_THAT(refusalOfOpening(folder / "list.nhdr"), HasSubstr("5 data files"));
    writeFile(folder / "list.nhdr", head + "data file: LIST\ns9.dat\ns10.dat\ns11.dat\ns12.dat\nnone.dat\n");
    EXPECT_THAT(refusalOfOpening(folder / "list.nhdr"), HasSubstr("none.dat"));
    writeFile(folder / "pattern.nhdr", head + "data file: s%d.dat 9 13 1\n");
    writeSlices(3);
    EXPECT_THAT(refusalOfOpening(folder / "pattern.nhdr"),
                AllOf(HasSubstr("s12.dat"), HasSubstr("too short")));
}

// Positions by the format's definition: origin and steps in the space that the header names.
TEST(ImportNrrd, PlacesAreTurnedToLps) {
    const ScratchFolder folder;
    const std::string data = voxelBytes(nrrdVoxels<std::uint8_t>());
    writeFile(folder / "a.nrrd",
              nrrdHeader("uchar", "raw",
                         "space: right-anterior-superior\nspace directions: (-2,0,0) (0,-3,0.5) (0.25,-1,4)\n"
                         "space origin: (10,20,30)\n") +
                  "\n" + data);
    const VolumeInfo info = openSource(folder / "a.nrrd", {})->info();
    EXPECT_TRUE(info.orientationKnown);
    const glm::dvec3 expected = glm::dvec3(-10, -20, 30) + 1.0 * glm::dvec3(2, 0, 0) +
                                2.0 * glm::dvec3(0, 3, 0.5) + 3.0 * glm::dvec3(-0.25, 1, 4);
    EXPECT_LT(glm::length(centreMm(info, 1, 2, 3) - expected), 1e-9);
    const auto spacingOf = [&](const std::string& place) {
        writeFile(folder / "b.nrrd", nrrdHeader("uchar", "raw", place) + "\n" + data);
        return openSource(folder / "b.nrrd", {})->info().spacingMm();
    };
    EXPECT_EQ(spacingOf("spacings: 0.5 2 4\n"), glm::dvec3(0.5, 2, 4));
    EXPECT_EQ(spacingOf("spacings: 0.5 2 4\nunits: \"cm\" \"cm\" \"cm\"\n"), glm::dvec3(5, 20, 40));
    EXPECT_EQ(spacingOf("space: LPS\nspace units: \"um\" \"um\" \"um\"\n"
                        "space directions: (500,0,0) (0,2000,0) (0,0,4000)\n"),
              glm::dvec3(0.5, 2, 4));
    EXPECT_FALSE(openSource(folder / "b.nrrd", {})->info().patientFromVoxel == glm::dmat4(1));
}

TEST(ImportNrrd, AnUnknownSpacingIsAskedFor) {
    const ScratchFolder folder;
    const std::string data = voxelBytes(nrrdVoxels<std::uint8_t>());
    for (const std::string place :
         {"", "spacings: 2 nan 4\n", "spacings: 2 3 4\nunits: \"ft\" \"ft\" \"ft\"\n",
          "space: LPS\nspace units: \"ft\" \"ft\" \"ft\"\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"}) {
        writeFile(folder / "a.nrrd", nrrdHeader("uchar", "raw", place) + "\n" + data);
        EXPECT_THAT(refusalOfOpening(folder / "a.nrrd"),
                    AllOf(HasSubstr("a.nrrd"), HasSubstr("--spacing X,Y,Z")));
        EXPECT_THAT(refusalOfOpening(folder.path()), HasSubstr("--spacing X,Y,Z"));
        const SourceOptions given{.spacingMm = glm::dvec3(2, 5, 7)};
        const glm::dvec3 expected =
            place.starts_with("spacings: 2 nan") ? glm::dvec3(2, 5, 4) : glm::dvec3(2, 5, 7);
        EXPECT_EQ(openSource(folder / "a.nrrd", given)->info().spacingMm(), expected) << place;
        EXPECT_EQ(openSource(folder.path(), given)->info().spacingMm(), expected) << place;
    }
    writeFile(folder / "a.nrrd", nrrdHeader("uchar", "raw") + "\n" + data);
    EXPECT_THAT(refusalOfOpening(folder / "a.nrrd", {.spacingMm = glm::dvec3(1)}),
                HasSubstr("one that does"));
    NiftiImage image;
    image.voxels = std::string(48, '\0');
    writeFile(folder / "a.nii", niftiBytes(image));
    EXPECT_THAT(refusalOfOpening(folder / "a.nii", {.spacingMm = glm::dvec3(1)}), HasSubstr("one that does"));
}

TEST(ImportNrrd, WhatIsNoVolumeIsRefused) {
    const ScratchFolder folder;
    const std::string data = voxelBytes(nrrdVoxels<std::uint8_t>());
    const auto expectRefusal = [&](const std::string& text, const char* what) {
        writeFile(folder / "a.nrrd", text);
        EXPECT_THAT(refusalOfOpening(folder / "a.nrrd"), AllOf(HasSubstr("a.nrrd"), HasSubstr(what)));
    };
    expectRefusal(nrrdHeader("uchar", "raw", kNrrdPlace + "Segment0_Name:=liver\n") + "\n" + data,
                  "--labels");
    expectRefusal(
        nrrdHeader("uchar", "raw", "kinds: RGB-color space space space\nspacings: nan 1 1 1\n", "3 4 5 1") +
            "\n" + data,
        "rgb-color");
    expectRefusal(
        nrrdHeader("uchar", "raw", "kinds: vector space space space\nspacings: nan 1 1 1\n", "3 4 5 1") +
            "\n" + data,
        "one value per voxel, found 3 values");
    expectRefusal(nrrdHeader("uchar", "raw", "spacings: 1 1 1 1\n", "3 4 5 1") + "\n" + data,
                  "three axes of space");
    expectRefusal(nrrdHeader("uchar", "raw", "spacings: 1 1 1\n", "3 4 6") + "\n" + data, "too short");
    expectRefusal(nrrdHeader("uchar", "raw", "spacings: 1 1 1\n", "3 4 4") + "\n" + data, "12 bytes more");
    expectRefusal(nrrdHeader("uchar", "gzip", "spacings: 1 1 1\n", "2000000 2000000 1000") + "\n" +
                      gzip(data),
                  "too short");
    expectRefusal(nrrdHeader("short", "raw", kNrrdPlace, "3 4 5") + "\n" + data + data, "endian");
    expectRefusal(nrrdHeader("uchar", "raw", "spacings: 1 0 1\n") + "\n" + data, "spacing");
    expectRefusal(nrrdHeader("uchar", "raw", "space: LPS\nspace directions: (1,0,0) (1,0,0) (0,0,1)\n") +
                      "\n" + data,
                  "singular");
    expectRefusal(nrrdHeader("uchar", "bzip2") + "\n" + data, "raw, gzip or text");
    // Of a folder it is left out, as labels are.
    writeFile(folder / "a.nrrd",
              nrrdHeader("uchar", "raw", kNrrdPlace + "Segment0_Name:=liver\n") + "\n" + data);
    writeFile(folder / "b.nrrd", nrrdHeader("uchar", "raw", kNrrdPlace) + "\n" + data);
    EXPECT_THAT(openSource(folder.path(), {})->describe(), HasSubstr("NRRD"));
}

// Text of the header would become voxels.
TEST(ImportNrrd, DataAtTheEndDoNotReachIntoTheHeader) {
    const ScratchFolder folder;
    const std::vector<std::uint8_t> values = nrrdVoxels<std::uint8_t>();
    const std::string data = voxelBytes(values),
                      header = nrrdHeader("uchar", "raw", kNrrdPlace + "byte skip: -1\n") + "\n";
    for (const char* before : {"", "some other bytes"}) {
        writeFile(folder / "a.nrrd", header + before + data);
        EXPECT_EQ(readAll<std::uint8_t>(*openSource(folder / "a.nrrd", {})), values) << before;
    }
    for (const std::size_t left : {59u, 30u, 0u}) {
        writeFile(folder / "a.nrrd", header + data.substr(0, left));
        EXPECT_THAT(refusalOfOpening(folder / "a.nrrd"), AllOf(HasSubstr("a.nrrd"), HasSubstr("too short")))
            << left;
    }
    writeFile(folder / "b.nhdr",
              nrrdHeader("uchar", "raw", kNrrdPlace + "line skip: 2\nbyte skip: -1\ndata file: b.raw\n"));
    writeFile(folder / "b.raw", "one line\nanother\n" + data);
    EXPECT_EQ(readAll<std::uint8_t>(*openSource(folder / "b.nhdr", {})), values);
    writeFile(folder / "b.raw", "one line\nanother\n" + data.substr(1));
    EXPECT_THAT(refusalOfOpening(folder / "b.nhdr"), AllOf(HasSubstr("b.raw"), HasSubstr("too short")));
}

TEST(ImportNrrd, TextHasOneWordForEveryValue) {
    const ScratchFolder folder;
    const auto write = [&](const std::string& first, int others, const std::string& last) {
        std::string text = first;
        for (int i = 0; i < others; ++i)
            text += i % 4 == 3 ? "\n5" : ", 5";
        writeFile(folder / "a.nrrd", nrrdHeader("short", "text") + "\n" + text + last + "\n");
        return nrrdHeader("short", "text").size() + 1;
    };
    const auto refused = [&] { return refusal([&] { readAll<float>(*openSource(folder / "a.nrrd", {})); }); };
    write(std::string(60, '0') + "1234", 59, "");
    std::vector<float> expected(60, 5);
    expected[0] = 1234;
    EXPECT_EQ(readAll<float>(*openSource(folder / "a.nrrd", {})), expected);
    // Cut into two words, it would be as many values as there should be.
    const std::size_t at = write(std::string(64, '0') + "1234", 58, "");
    EXPECT_THAT(refused(), AllOf(HasSubstr("a.nrrd"), HasSubstr("64 characters at most"),
                                 HasSubstr("before byte " + std::to_string(at + 65))));
    write("5", 59, " 5");
    EXPECT_THAT(refused(), AllOf(HasSubstr("a.nrrd"), HasSubstr("1 more")));
    const std::size_t word = write("five", 59, "");
    EXPECT_THAT(refused(), HasSubstr("\"five\" before byte " + std::to_string(word + 4)));
}

TEST(ImportNrrd, FilesOfAPatternAreCountedBeforeTheyAreNamed) {
    const ScratchFolder folder;
    const auto refused = [&](const std::string& sizes, const std::string& pattern) {
        writeFile(folder / "a.nhdr",
                  nrrdHeader("uchar", "raw", kNrrdPlace, sizes) + "data file: s%d.raw " + pattern + "\n");
        return refusalOfOpening(folder / "a.nhdr");
    };
    EXPECT_THAT(refused("3 4 5", "0 999999999 1"),
                HasSubstr("5 data files, as its sizes say, found 1000000000"));
    EXPECT_THAT(refused("1 1 2000000", "1 2000000 1"), HasSubstr("65536 data files at most, found 2000000"));
    EXPECT_THAT(refused("3 4 5", "1 2 1 3"), HasSubstr("5 data files"));
    EXPECT_THAT(refused("3 4 5", "5 1 1"), HasSubstr("leads from its first number"));
}

TEST(ImportNrrd, EveryTruncationAndRandomDamageIsAnErrorOrRead) {
    const ScratchFolder folder;
    const std::string data = voxelBytes(nrrdVoxels<std::int16_t>());
    for (const bool packed : {false, true}) {
        const std::string header =
                              nrrdHeader("short", packed ? "gzip" : "raw", kNrrdPlace + "endian: little\n") +
                              "\n",
                          whole = header + (packed ? gzip(data) : data);
        expectPrefixesRefused(folder / "a.nrrd", whole, "a.nrrd");
        expectDamageHarmless(folder / "a.nrrd", whole, header.size());
    }
}

} // namespace
} // namespace tessera::test

// tests/bricking/import/files/stack_test.cpp: stacks of pictures: values, the order of slices and gaps in it,
// spacings and calibrations.
#include "bricking/import/catalogue.h"
#include "bricking/import/files/stack/slice_names.h"
#include "tests/support/stack_writers.h"

#include <glm/geometric.hpp>
#include <gmock/gmock.h>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

template <class In, class Out = In> void expectStackCodings() {
    for (const char* compression : {"none", "lzw", "zip", "packbits"})
        for (const int tile : {0, 16}) {
            const ScratchFolder folder;
            OiioSpec spec{.compression = compression, .tile = tile, .rowsPerStrip = tile ? 0 : 7};
            writeByOiio<In>(folder / "pages.tif", spec, 3);
            std::vector<Out> expected;
            for (const In value : stackValues<In>(spec.width, spec.height, 3))
                expected.push_back(static_cast<Out>(value));
            EXPECT_EQ(readAll<Out>(*openSource(folder / "pages.tif", kCubes)), expected)
                << compression << tile;
            fs::remove(folder / "pages.tif");
            for (int z = 0; z < 3; ++z)
                writeByOiio<In>(folder / ("s" + std::to_string(9 + z) + ".tif"), spec, 1, z);
            EXPECT_EQ(readAll<Out>(*openSource(folder.path(), kCubes)), expected) << compression << tile;
        }
}

TEST(ImportStack, EveryTypeAndCodingReadsBackEqual) {
    expectStackCodings<std::uint8_t>();
    expectStackCodings<std::uint16_t>();
    expectStackCodings<std::int16_t>();
    expectStackCodings<float>();
    expectStackCodings<std::int8_t, std::int16_t>();
    expectStackCodings<std::uint32_t, float>();
}

TEST(ImportStack, RowsAreThoseOfSlices) {
    for (const char* compression : {"none", "zip", "lzw"})
        for (const auto& [tile, strip] : {std::pair{0, 1}, {0, 7}, {0, 45}, {16, 0}}) {
            SCOPED_TRACE(testing::Message() << compression << " tiles " << tile << " strips " << strip);
            const ScratchFolder folder;
            OiioSpec spec;
            spec.compression = compression, spec.tile = tile, spec.rowsPerStrip = strip;
            writeByOiio<std::uint16_t>(folder / "a.tif", spec, 3);
            expectRowsOfSlices([&] { return openSource(folder / "a.tif", kCubes); }, RowAccess::any);
        }
    const ScratchFolder folder;
    for (int z = 0; z < 3; ++z)
        writeByOiio<std::uint8_t>(folder / ("s" + std::to_string(z) + ".png"), {}, 1, z);
    expectRowsOfSlices([&] { return openSource(folder.path(), kCubes); }, RowAccess::inOrder);
}

TEST(ImportStack, BothOrdersOfBytesAndBigTiff) {
    const ScratchFolder folder;
    const std::vector<std::uint16_t> values = stackValues<std::uint16_t>(5, 6, 3);
    const std::vector<std::int16_t> signedValues = stackValues<std::int16_t>(5, 6, 3);
    for (const bool big : {false, true})
        for (const bool isLong : {false, true}) {
            OwnTiff tiff = ownTiff();
            tiff.big = big, tiff.isLong = isLong;
            tiff.pixels = voxelBytes(values, big);
            writeFile(folder / "a.tif", tiff.bytes());
            EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder / "a.tif", kCubes)), values) << big << isLong;
            tiff.format = 2;
            tiff.pixels = voxelBytes(signedValues, big);
            writeFile(folder / "a.tif", tiff.bytes());
            EXPECT_EQ(readAll<std::int16_t>(*openSource(folder / "a.tif", kCubes)), signedValues)
                << big << isLong;
        }
}

TEST(ImportStack, FloatsKeepTheirValuesAndAbsentOnesAreCounted) {
    const ScratchFolder folder;
    OwnTiff tiff{.width = 2, .height = 1, .rows = 1, .pages = 2, .bits = 32, .format = 3};
    tiff.pixels = voxelBytes<float>({1.5f, std::nanf(""), -3.25f, 1e30f});
    writeFile(folder / "a.tif", tiff.bytes());
    const auto source = openSource(folder / "a.tif", kCubes);
    EXPECT_EQ(readAll<float>(*source), (std::vector<float>{1.5f, -3.25f, -3.25f, 1e30f}));
    EXPECT_EQ(source->info().nonFiniteVoxels, 1u);
    tiff.bits = 16; // half floats: 1.5, -2, 65504, 2^-24
    tiff.pixels = voxelBytes<std::uint16_t>({0x3e00, 0xc000, 0x7bff, 0x0001});
    writeFile(folder / "h.tif", tiff.bytes());
    EXPECT_EQ(readAll<float>(*openSource(folder / "h.tif", kCubes)),
              (std::vector<float>{1.5f, -2, 65504, 0x1p-24f}));
}

TEST(ImportStack, PngSlicesAreOrderedByTheirNumbers) {
    for (const bool isWide : {false, true}) {
        const ScratchFolder folder;
        const auto write = [&](const std::string& name, int z) {
            if (isWide)
                writeByOiio<std::uint16_t>(folder / name, {}, 1, z);
            else
                writeByOiio<std::uint8_t>(folder / name, {}, 1, z);
        };
        for (int z = 0; z < 12; ++z)
            write("slice" + std::to_string(z) + ".png", z); // slice10 after slice9
        const auto source = openSource(folder.path(), kCubes);
        EXPECT_EQ(source->info().extentVoxels, glm::ivec3(37, 45, 12));
        EXPECT_THAT(source->describe(), HasSubstr("12 slices, slice#.png"));
        if (isWide)
            EXPECT_EQ(readAll<std::uint16_t>(*source), stackValues<std::uint16_t>(37, 45, 12));
        else
            EXPECT_EQ(readAll<std::uint8_t>(*source), stackValues<std::uint8_t>(37, 45, 12));
        EXPECT_EQ(lookThrough(folder.path(), kCubes).rows.size(), 1u);
    }
}

TEST(ImportStack, NamesThatLeaveTheOrderOpenAreRefused) {
    const ScratchFolder folder;
    const auto expectRefusal = [&](std::initializer_list<const char*> names, const std::string& what) {
        for (const auto& entry : fs::directory_iterator(folder.path()))
            fs::remove(entry.path());
        int z = 0;
        for (const char* name : names)
            writeByOiio<std::uint8_t>(folder / name, {}, 1, z++);
        EXPECT_THAT(refusalOfOpening(folder.path(), kCubes), HasSubstr(what));
    };
    expectRefusal({"s1.tif", "s2.tif", "s4.tif", "s7.tif"}, "3 missing: 3, 5 to 6");
    expectRefusal({"s1.tif", "s2.tif", "t3.tif"}, "alike but for one number");
    expectRefusal({"s1.tif", "s2.png"}, "a picture of the kind of s1.tif (tiff)");
    expectRefusal({"c1_z1.tif", "c1_z2.tif", "c2_z1.tif", "c2_z2.tif"}, "2 that differ");
    expectRefusal({"s1.tif", "s01.tif", "s2.tif"}, "every number once");
    expectRefusal({"s1.tif"}, "two slices or more");
    for (const int step : {2, 10}) {
        for (const auto& entry : fs::directory_iterator(folder.path()))
            fs::remove(entry.path());
        for (int z = 0; z < 3; ++z)
            writeByOiio<std::uint8_t>(folder / ("s" + std::to_string(z * step + 5) + ".tif"), {}, 1, z);
        EXPECT_EQ(readAll<std::uint8_t>(*openSource(folder.path(), kCubes)),
                  stackValues<std::uint8_t>(37, 45, 3));
    }
}

// Names alone: their order, places in steps that all share, and what is missing.
TEST(ImportStack, NumbersOfNamesArePlaces) {
    const auto ordered = [](const std::vector<std::string>& numbers) {
        std::vector<fs::path> files;
        for (const std::string& number : numbers)
            files.emplace_back("f/c1_s" + number + "b.tif");
        return orderedSlices("f", files);
    };
    const SliceNames three = ordered({"35", "5", "15"});
    EXPECT_EQ(three.pattern, "c1_s#b.tif");
    EXPECT_EQ(three.files, (std::vector<fs::path>{"f/c1_s5b.tif", "f/c1_s15b.tif", "f/c1_s35b.tif"}));
    EXPECT_EQ(three.places, (std::vector<std::uint64_t>{0, 1, 3}));
    EXPECT_EQ(three.missing, "25");
    EXPECT_EQ(three.missingCount, 1u);
    EXPECT_EQ(ordered({"1", "2", "9"}).missing, "3 to 8");
    EXPECT_EQ(ordered({"1", "2", "9"}).missingCount, 6u);
    EXPECT_EQ(ordered({"4", "6", "8"}).missing, "");
    std::vector<std::string> odd = {"1", "2"};
    std::string missing;
    for (int n = 4; n <= 18; n += 2) {
        odd.push_back(std::to_string(n));
        missing += (n == 4 ? "" : ", ") + std::to_string(n - 1);
    }
    EXPECT_EQ(ordered(odd).missing, missing) << "eight";
    odd.emplace_back("20");
    EXPECT_EQ(ordered(odd).missing, missing + " and more");
    EXPECT_EQ(ordered(odd).missingCount, 9u);
    EXPECT_EQ(ordered({"9000000000000000000", "9000000000000000002"}).places,
              (std::vector<std::uint64_t>{0, 1}));
    EXPECT_THAT(refusal([&] {
                    ordered({"1", "9300000000000000000"});
                }),
                HasSubstr("a number of 18 digits at most"));
    EXPECT_THAT(refusal([&] { ordered({"7", "07"}); }), HasSubstr("no number that differs in c#_s#b"));
    EXPECT_THAT(refusal([&] { orderedSlices("f", {}); }), HasSubstr("two slices or more, found none"));
}

// ImageJ's and OME's units of length, each of another factor for an axis.
TEST(ImportStack, UnitsOfLengthInDescriptions) {
    const ScratchFolder folder;
    const auto spacing = [&](const std::string& description) {
        OwnTiff tiff{
            .width = 4, .height = 4, .rows = 4, .pages = 2, .bits = 8, .pixels = std::string(32, '\7')};
        tiff.description = description;
        tiff.perX = 4, tiff.perY = 2, tiff.unit = 3;
        writeFile(folder / "a.tif", tiff.bytes());
        return openSource(folder / "a.tif", {})->info().spacingMm();
    };
    for (const auto& [unit, mm] : std::vector<std::pair<std::string, double>>{{"mm", 1},
                                                                              {"millimeter", 1},
                                                                              {"cm", 10},
                                                                              {"m", 1000},
                                                                              {"um", 1e-3},
                                                                              {"micron", 1e-3},
                                                                              {"microns", 1e-3},
                                                                              {"micrometer", 1e-3},
                                                                              {"\\u00B5m", 1e-3},
                                                                              {"\xb5m", 1e-3},
                                                                              {"\xc2\xb5m", 1e-3},
                                                                              {"\xce\xbcm", 1e-3},
                                                                              {"inch", 25.4},
                                                                              {"in", 25.4}}) {
        const glm::dvec3 imageJ = spacing("ImageJ=1.53t\nimages=2\nslices=2\nunit=" + unit + "\nspacing=3\n");
        EXPECT_LT(glm::length(imageJ / mm - glm::dvec3(0.25, 0.5, 3)), 1e-6) << unit;
        std::string sizes;
        for (const auto& [axis, size] : {std::pair("X", "0.5"), {"Y", "0.75"}, {"Z", "2"}})
            sizes += std::string(" PhysicalSize") + axis + "=\"" + size + "\" PhysicalSize" + axis +
                     "Unit=\"" + unit + "\"";
        const glm::dvec3 ome =
            spacing("<?xml version=\"1.0\"?><OME><Image><Pixels SizeZ=\"2\"" + sizes + "/></Image></OME>");
        EXPECT_LT(glm::length(ome / mm - glm::dvec3(0.5, 0.75, 2)), 1e-6) << unit;
    }
}

// Slices keep the places that their numbers say.
TEST(ImportStack, MissingSlicesAreInterpolatedOrRefused) {
    const ScratchFolder folder;
    const auto write = [&](std::initializer_list<int> numbers) {
        for (const auto& entry : fs::directory_iterator(folder.path()))
            fs::remove(entry.path());
        for (const int number : numbers)
            writeByOiio<std::int16_t>(folder / ("s" + std::to_string(number) + ".tif"), {}, 1, number);
    };
    write({1, 2, 4, 7});
    for (const bool mayMiss : {false, true})
        EXPECT_THAT(refusalOfOpening(folder.path(), {.allowMissing = mayMiss, .spacingMm = glm::dvec3(1)}),
                    AllOf(HasSubstr("--resample-z"), HasSubstr("3 missing: 3, 5 to 6")))
            << mayMiss;
    const SourceOptions evenly{.resampleZ = true, .spacingMm = glm::dvec3(1, 1, 2)};
    // Slices differ by a constant but for the columns' sign: between two of them lies their mean.
    const auto source = openSource(folder.path(), evenly);
    EXPECT_EQ(source->info().extentVoxels, glm::ivec3(37, 45, 7));
    EXPECT_EQ(source->info().spacingMm().z, 2);
    EXPECT_THAT(source->notes(), testing::Contains(HasSubstr("3 slices missing by their numbers, interp")));
    std::vector<std::int16_t> expected;
    for (int number = 1; number <= 7; ++number)
        for (const std::int16_t value : sliceValues<std::int16_t>(37, 45, number))
            expected.push_back(value); // linear in the number
    EXPECT_EQ(readAll<std::int16_t>(*source), expected);
    write({10, 14, 20}); // they share steps of two
    const auto shared = openSource(folder.path(), evenly);
    EXPECT_EQ(shared->info().extentVoxels.z, 6);
    expected.clear();
    for (int number = 10; number <= 20; number += 2)
        for (const std::int16_t value : sliceValues<std::int16_t>(37, 45, number))
            expected.push_back(value);
    EXPECT_EQ(readAll<std::int16_t>(*shared), expected);
    write({1, 2, 200000});
    EXPECT_THAT(refusalOfOpening(folder.path(), evenly), HasSubstr("65536 slices at most"));
    // Eight bits without a sign, rounded to the nearest number; of half, to the even one.
    for (const auto& entry : fs::directory_iterator(folder.path()))
        fs::remove(entry.path());
    for (const auto& [name, value] : {std::pair{"p1.tif", 1}, {"p2.tif", 250}, {"p4.tif", 5}}) {
        OwnTiff tiff{.width = 1, .height = 1, .rows = 1, .pages = 1, .bits = 8};
        tiff.pixels = std::string(1, static_cast<char>(value));
        writeFile(folder / name, tiff.bytes());
    }
    EXPECT_EQ(readAll<std::uint8_t>(*openSource(folder.path(), evenly)),
              (std::vector<std::uint8_t>{1, 250, 128, 5}));
}

TEST(ImportStack, EndingsOfNamesDoNotCount) {
    const ScratchFolder folder;
    for (const auto& [name, z] : {std::pair{"a1.TIF", 0}, {"a2.tif", 1}, {"a3.tiff", 2}}) {
        writeByOiio<std::uint8_t>(folder / "w.tif", {}, 1, z);
        fs::rename(folder / "w.tif", folder / name);
    }
    EXPECT_EQ(readAll<std::uint8_t>(*openSource(folder.path(), kCubes)),
              stackValues<std::uint8_t>(37, 45, 3));
    writeByOiio<std::uint8_t>(folder / "a1.tif", {});
    EXPECT_THAT(refusalOfOpening(folder.path(), kCubes), HasSubstr("every number once"));
}

// ImageJ keeps numbers with a sign so, and Hounsfield units.
TEST(ImportStack, CalibrationsOfImageJBecomeTheRescale) {
    const ScratchFolder folder;
    const auto write = [&](const std::string& calibration, std::uint32_t format = 1) {
        OwnTiff tiff = ownTiff();
        tiff.format = format;
        tiff.description = "ImageJ=1.53t\nimages=3\nslices=3\n" + calibration;
        writeFile(folder / "a.tif", tiff.bytes());
    };
    const auto info = [&] { return openSource(folder / "a.tif", kCubes)->info(); };
    write("cf=0\nc0=-32768.0\nc1=1.0\nvunit=Gray Value\n");
    EXPECT_EQ(info().rescaleIntercept, -32768);
    EXPECT_EQ(info().rescaleSlope, 1);
    EXPECT_EQ(info().unit, "");
    EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder / "a.tif", kCubes)),
              stackValues<std::uint16_t>(5, 6, 3));
    write("cf=0\nc0=-1000\nc1=0.5\nvunit=HU\n");
    EXPECT_EQ(info().rescaleIntercept, -1000);
    EXPECT_EQ(info().rescaleSlope, 0.5);
    EXPECT_EQ(info().unit, "HU");
    for (const char* none : {"", "cf=20\n", "vunit=HU\n"}) {
        write(none);
        EXPECT_EQ(info().rescaleIntercept, 0) << none;
        EXPECT_EQ(info().rescaleSlope, 1) << none;
    }
    const auto expectRefusal = [&](const std::string& calibration, const char* what) {
        write(calibration);
        EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), AllOf(HasSubstr("a.tif"), HasSubstr(what)));
    };
    expectRefusal("cf=4\nc0=1\nc1=2\n", "found \"Exponential\"");
    expectRefusal("cf=7\nc0=1\nc1=2\nc2=1\nc3=5\n", "found \"Rodbard\"");
    expectRefusal("cf=21\n", "found \"Uncalibrated OD\"");
    const std::vector<std::pair<int, std::string>> functions = {
        {1, "2nd Degree Polynomial"},
        {2, "3rd Degree Polynomial"},
        {3, "4th Degree Polynomial"},
        {5, "Power"},
        {6, "Log"},
        {8, "Gamma Variate"},
        {9, "y = a+b*ln(x-c)"},
        {10, "Rodbard (NIH Image)"},
        {12, "Gaussian"},
        {11, "Exponential with Offset"},
        {13, "Exponential Recovery"},
        {22, "Custom"},
        {99, "function 99"},
        {14, "function 14"}}; // of ij.measure.Calibration
    for (const auto& [number, name] : functions)
        expectRefusal("cf=" + std::to_string(number) + "\n", ("found \"" + name + "\"").c_str());
    expectRefusal("cf=0\nc0=5\n", "c0 and c1");
    expectRefusal("cf=0\nc0=5\nc1=0\n", "c1");
    expectRefusal("cf=0\nc0=5\nc1=1\nzeroclip=true\n", "zeroclip");
    write("cf=0\nc0=-32768\nc1=1\n", 2);
    EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), HasSubstr("without a sign"));
    fs::remove(folder / "a.tif");
    for (const char* name : {"s1.tif", "s2.tif"}) {
        OwnTiff tiff{.pages = 1, .pixels = std::string(60, 'x')};
        tiff.description = "ImageJ=1.53t\ncf=0\nc0=-32768\nc1=1\n";
        writeFile(folder / name, tiff.bytes());
    }
    EXPECT_EQ(openSource(folder.path(), kCubes)->info().rescaleIntercept, -32768);
    OwnTiff other{.pages = 1, .pixels = std::string(60, 'x')};
    other.description = "ImageJ=1.53t\ncf=0\nc0=-1000\nc1=1\n";
    writeFile(folder / "s2.tif", other.bytes());
    EXPECT_THAT(refusalOfOpening(folder.path(), kCubes),
                AllOf(HasSubstr("s2.tif"), HasSubstr("as in s1.tif")));
}

// A TIFF's XPosition and YPosition: where a picture was cut from a larger one.
TEST(ImportStack, CroppedPicturesAreReadWhole) {
    for (const int tile : {0, 16}) {
        const ScratchFolder folder;
        writeByOiio<std::uint16_t>(folder / "a.tif",
                                   {.tile = tile, .rowsPerStrip = tile ? 0 : 7, .x = 20, .y = 35}, 3);
        const auto source = openSource(folder / "a.tif", kCubes);
        EXPECT_EQ(source->info().extentVoxels, glm::ivec3(37, 45, 3));
        EXPECT_EQ(readAll<std::uint16_t>(*source), stackValues<std::uint16_t>(37, 45, 3)) << tile;
    }
}

TEST(ImportStack, PalettesThatAreGreyAreTaken) {
    const ScratchFolder folder;
    const auto write = [&](const std::function<int(int)>& blue, int scale = 257) {
        OwnTiff tiff{.pages = 2, .bits = 8};
        tiff.pixels = voxelBytes(stackValues<std::uint8_t>(5, 6, 2));
        tiff.other[262] = 3;
        for (int channel = 0; channel < 3; ++channel)
            for (int i = 0; i < 256; ++i)
                tiff.palette.push_back(static_cast<std::uint16_t>((channel == 2 ? blue(i) : i) * scale));
        writeFile(folder / "a.tif", tiff.bytes());
    };
    write([](int i) { return i; });
    const auto source = openSource(folder / "a.tif", kCubes);
    EXPECT_EQ(readAll<std::uint8_t>(*source), stackValues<std::uint8_t>(5, 6, 2));
    EXPECT_THAT(source->notes(), testing::Contains(HasSubstr("palette")));
    write([](int i) { return i; }, 256); // other numbers once they are read
    EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), HasSubstr("a palette of colours"));
    write([](int i) { return i == 77 ? 78 : i; });
    EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), HasSubstr("a palette of colours"));
    write([](int i) { return 255 - i; });
    EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), HasSubstr("a palette of colours"));
}

TEST(ImportStack, BytesBehindAPngAreIgnored) {
    const ScratchFolder folder;
    for (int z = 0; z < 3; ++z) {
        const fs::path file = folder / ("p" + std::to_string(z) + ".png");
        writeByOiio<std::uint8_t>(file, {}, 1, z);
        std::ofstream(file, std::ios::binary | std::ios::app)
            << std::string(static_cast<std::size_t>(3 + z), '\xff');
    }
    EXPECT_EQ(readAll<std::uint8_t>(*openSource(folder.path(), kCubes)),
              stackValues<std::uint8_t>(37, 45, 3));
}

// Other volumes that cannot be opened do not make pictures illustrations; those that wait for a spacing do.
TEST(ImportStack, ADamagedVolumeDoesNotHideAStack) {
    const ScratchFolder folder;
    for (int z = 0; z < 3; ++z)
        writeByOiio<std::uint8_t>(folder / ("p" + std::to_string(z) + ".tif"), {}, 1, z);
    NiftiImage image;
    image.voxels = std::string(48, '\0');
    writeFile(folder / "a.nii", niftiBytes(image).substr(0, 380));
    EXPECT_EQ(readAll<std::uint8_t>(*openSource(folder.path(), kCubes)),
              stackValues<std::uint8_t>(37, 45, 3));
    const Catalogue catalogue = lookThrough(folder.path(), kCubes);
    EXPECT_THAT(passedOverText(catalogue, chooseRow(catalogue, kCubes)), HasSubstr("a.nii"));
    fs::remove(folder / "a.nii");
    writeFile(folder / "pages.tif", ownTiff().bytes()); // of several pages
    EXPECT_THAT(refusalOfOpening(folder.path()), AllOf(HasSubstr("pages.tif"), HasSubstr("--spacing X,Y,Z")));
    EXPECT_THAT(openSource(folder.path(), kCubes)->describe(), HasSubstr("TIFF of 3 pages"));
    for (int z = 0; z < 3; ++z)
        fs::remove(folder / ("p" + std::to_string(z) + ".tif"));
    const std::string whole = ownTiff().bytes();
    writeFile(folder / "pages.tif", whole.substr(0, whole.size() - 10)); // within its last page
    EXPECT_THAT(refusalOfOpening(folder.path(), kCubes),
                AllOf(HasSubstr("pages.tif"), HasSubstr("truncated")));
}

TEST(ImportStack, PicturesBesideAVolumeAreNoStack) {
    const ScratchFolder folder;
    NiftiImage image;
    image.voxels = std::string(48, '\0');
    writeFile(folder / "a.nii", niftiBytes(image));
    for (const char* name : {"p1.png", "p2.png", "p3.png"})
        writeByOiio<std::uint8_t>(folder / name, {});
    EXPECT_THAT(openSource(folder.path(), {})->describe(), HasSubstr("NIfTI"));
}

TEST(ImportStack, SpacingsAreSaidOrAskedFor) {
    const ScratchFolder folder;
    const auto write = [&](const std::string& description, std::uint32_t perX = 0) {
        OwnTiff tiff{
            .width = 4, .height = 4, .rows = 4, .pages = 2, .bits = 8, .pixels = std::string(32, '\7')};
        tiff.description = description;
        tiff.perX = perX, tiff.perY = perX / 2;
        tiff.unit = 3; // a centimetre
        writeFile(folder / "a.tif", tiff.bytes());
    };
    const auto spacing = [&] { return openSource(folder / "a.tif", {})->info().spacingMm(); };
    const auto expectNear = [&](const glm::dvec3& expected) {
        const glm::dvec3 found = spacing();
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(found[axis], expected[axis], 1e-6 * expected[axis]);
    };
    write("ImageJ=1.53t\nimages=2\nslices=2\nunit=mm\nspacing=2.5\n", 4); // four pixels a mm, two
    expectNear({0.25, 0.5, 2.5});
    write("ImageJ=1.53t\nimages=2\nslices=2\nunit=micron\nspacing=1.5\n", 4);
    expectNear({0.25e-3, 0.5e-3, 1.5e-3});
    write(
        R"(<?xml version="1.0"?><OME><Image><Pixels SizeC="1" SizeT="1" SizeX="4" SizeY="4" SizeZ="2" )"
        R"(PhysicalSizeX="0.5" PhysicalSizeY="0.75" PhysicalSizeZ="2" PhysicalSizeZUnit="mm"/></Image></OME>)");
    expectNear({0.5e-3, 0.75e-3, 2});
    const auto expectAsked = [&](const char* said) {
        EXPECT_THAT(refusalOfOpening(folder / "a.tif"), AllOf(HasSubstr("--spacing X,Y,Z"), HasSubstr(said)));
        EXPECT_EQ(openSource(folder / "a.tif", {.spacingMm = glm::dvec3(1, 2, 3)})->info().spacingMm(),
                  glm::dvec3(1, 2, 3));
    };
    write("");
    expectAsked("no spacing");
    write("", 4);
    expectAsked("2.5 x 5 mm within slices, nothing between them");
    EXPECT_THAT(openSource(folder / "a.tif", kCubes)->notes(),
                testing::Contains(HasSubstr("--spacing is taken")));
    write("ImageJ=1.53t\nimages=2\nslices=2\nunit=pixel\nspacing=1.5\n", 4);
    expectAsked("no spacing");
    // ImageJ leaves out a spacing of 1, and units that are that of x.
    write("ImageJ=1.53t\nimages=2\nslices=2\nunit=cm\n", 4);
    expectNear({2.5, 5, 10});
    write("ImageJ=1.53t\nimages=2\nslices=2\nunit=mm\nyunit=cm\nzunit=micron\nspacing=500\n", 4);
    expectNear({0.25, 5, 0.5});
    write("ImageJ=1.53t\nimages=2\nslices=2\nunit=mm\nzunit=inch\n", 4);
    expectNear({0.25, 0.5, 25.4});
    write("ImageJ=1.53t\nimages=2\nslices=2\n", 4);
    expectAsked("2.5 x 5 mm within slices, nothing between them");
    write("ImageJ=1.53t\nimages=2\nslices=2\nunit=mm\nzunit=pixel\nspacing=2\n", 4);
    expectAsked("nothing between them");
    write("ImageJ=1.53t\nimages=2\nslices=2\nunit=mm\nspacing=0\n", 4);
    expectAsked("nothing between them");
    write("ImageJ=1.53t\nimages=2\nslices=2\nunit=mm\nyunit=pixel\nspacing=2\n", 4);
    expectAsked("nothing within them");
    write("ImageJ=1.53t\nimages=2\nchannels=2\nunit=mm\nspacing=1\n", 4);
    EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), HasSubstr("series"));
    write("ImageJ=1.53t\nimages=3\nslices=3\nunit=mm\nspacing=1\n", 4);
    EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), HasSubstr("3 pages"));
    write(R"(<OME><Pixels SizeC="2" SizeT="1" SizeZ="1"/></OME>)");
    EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), HasSubstr("--series N"));
}

// Beyond 4 GiB ImageJ writes an entry for the first page alone.
TEST(ImportStack, PagesThatImageJAppendsAreRead) {
    const ScratchFolder folder;
    const std::vector<std::uint16_t> values = stackValues<std::uint16_t>(5, 6, 4);
    const std::size_t slice = 5 * 6 * 2;
    for (const bool big : {false, true}) {
        OwnTiff tiff{.big = big, .rows = 6, .pages = 1};
        tiff.description = "ImageJ=1.53t\nimages=4\nslices=4\nunit=mm\nspacing=2\n";
        const std::string pixels = voxelBytes(values, big);
        tiff.pixels = pixels.substr(0, slice);
        std::string file = tiff.bytes();
        // Its pixels lie behind everything else, and so do the pages without an entry.
        OwnTiff moved = tiff;
        moved.other[273] = static_cast<std::uint32_t>(file.size());
        writeFile(folder / "a.tif", moved.bytes() + pixels);
        EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder / "a.tif", kCubes)), values) << big;
        writeFile(folder / "a.tif", moved.bytes() + pixels.substr(0, 4 * slice - 1));
        EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), HasSubstr("truncated"));
    }
}

} // namespace
} // namespace tessera::test

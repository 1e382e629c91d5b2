// tests/bricking/import/files/stack_test.cpp: stacks of pictures, written byte by byte or by OpenImageIO:
// values, the order of slices, spacings, every lie refused, and memory that a slice's size does not decide.
#include "bricking/import/catalogue.h"
#include "tests/support/import_test_tools.h"

#include <OpenImageIO/imageio.h>
#include <functional>
#include <gmock/gmock.h>
#include <map>
#include <random>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

const SourceOptions kCubes{.spacingMm = glm::dvec3(1)};

/// Of slice z: no two slices, rows or columns are alike.
template <class T> std::vector<T> sliceValues(int width, int height, int z) {
    std::vector<T> values;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            values.push_back(static_cast<T>(z * 1013 + y * 131 + x * 17 + (x * y) % 7 - 40));
    return values;
}
template <class T> std::vector<T> stackValues(int width, int height, int slices) {
    std::vector<T> all;
    for (int z = 0; z < slices; ++z)
        for (const T value : sliceValues<T>(width, height, z))
            all.push_back(value);
    return all;
}

template <class T> OIIO::TypeDesc typeOfPixels() {
    if constexpr (std::is_same_v<T, std::int8_t>)
        return OIIO::TypeDesc::INT8; // OpenImageIO has plain char for it
    else
        return OIIO::BaseTypeFromC<T>::value;
}

struct OiioSpec {
    int width = 37, height = 45;
    const char* compression = "none";
    int tile = 0, rowsPerStrip = 0, channels = 1, x = 0, y = 0;
    std::map<std::string, std::string> texts = {};
};

/// Pages of one file; the n-th has slice first + n.
template <class T>
void writeByOiio(const fs::path& path, const OiioSpec& from, int pages = 1, int first = 0) {
    OIIO::ImageSpec spec(from.width, from.height, from.channels, typeOfPixels<T>());
    spec.attribute("compression", from.compression);
    if (from.rowsPerStrip > 0)
        spec.attribute("tiff:RowsPerStrip", from.rowsPerStrip);
    spec.tile_width = spec.tile_height = from.tile;
    spec.x = from.x, spec.y = from.y;
    for (const auto& [key, value] : from.texts)
        spec.attribute(key, value);
    const auto out = OIIO::ImageOutput::create(path.string());
    ASSERT_TRUE(out);
    const std::vector<OIIO::ImageSpec> specs(static_cast<std::size_t>(pages), spec);
    ASSERT_TRUE(pages == 1 ? out->open(path.string(), spec) : out->open(path.string(), pages, specs.data()))
        << out->geterror();
    for (int page = 0; page < pages; ++page) {
        if (page > 0) {
            ASSERT_TRUE(out->open(path.string(), spec, OIIO::ImageOutput::AppendSubimage)) << out->geterror();
        }
        const std::vector<T> values = sliceValues<T>(from.width * from.channels, from.height, first + page);
        ASSERT_TRUE(out->write_image(typeOfPixels<T>(), values.data())) << out->geterror();
    }
    ASSERT_TRUE(out->close());
}

/// A TIFF file, byte by byte: pages without compression, `rows` in a strip.
struct OwnTiff {
    bool big = false, isLong = false; // order of bytes, BigTIFF
    int width = 5, height = 6, rows = 4, pages = 3;
    std::uint32_t bits = 16, format = 1;
    std::string pixels = {}; // of all pages
    std::string description = {};
    std::uint32_t perX = 0, perY = 0, unit = 1; // resolution
    std::map<int, std::uint32_t> other = {};    // fields in place of these, or besides
    std::vector<std::uint16_t> palette = {};

    std::string bytes() const {
        std::string file = big ? "MM" : "II";
        append(file, isLong ? 43 : 42, 2);
        if (isLong)
            append(file, 8, 2), append(file, 0, 2);
        const std::size_t pointer = isLong ? 8 : 4;
        append(file, 0, pointer);
        std::size_t nextAt = file.size() - pointer;
        const auto pageBytes = pixels.size() / static_cast<std::size_t>(pages);
        const std::size_t stripBytes =
            pageBytes / static_cast<std::size_t>(height) * static_cast<std::size_t>(rows);
        for (std::size_t page = 0; page < static_cast<std::size_t>(pages); ++page) {
            std::vector<std::uint64_t> offsets, lengths;
            for (std::size_t at = 0; at < pageBytes; at += stripBytes) {
                const std::size_t length = std::min(stripBytes, pageBytes - at);
                offsets.push_back(file.size());
                lengths.push_back(length);
                file += pixels.substr(page * pageBytes + at, length);
            }
            const std::size_t offsetsAt = file.size();
            for (const std::uint64_t offset : offsets)
                append(file, offset, 4);
            const std::size_t lengthsAt = file.size();
            for (const std::uint64_t length : lengths)
                append(file, length, 4);
            const std::size_t textAt = file.size();
            file += description + std::string(1, '\0');
            const std::size_t ratiosAt = file.size();
            for (const std::uint32_t number : {perX, 1u, perY, 1u})
                append(file, number, 4);
            const std::size_t paletteAt = file.size();
            for (const std::uint16_t number : palette)
                append(file, number, 2);
            struct Field {
                int type;
                std::uint64_t count, value;
            };
            std::map<int, Field> fields = {
                {256, {4, 1, static_cast<std::uint64_t>(width)}},
                {257, {4, 1, static_cast<std::uint64_t>(height)}},
                {258, {3, 1, bits}},
                {259, {3, 1, 1}},
                {262, {3, 1, 1}},
                {273, {4, offsets.size(), offsets.size() == 1 ? offsets[0] : offsetsAt}},
                {277, {3, 1, 1}},
                {278, {4, 1, static_cast<std::uint64_t>(rows)}},
                {279, {4, lengths.size(), lengths.size() == 1 ? lengths[0] : lengthsAt}},
                {339, {3, 1, format}}};
            if (isLong && offsets.size() == 2) { // eight bytes fit in place
                const auto both = [&](const std::vector<std::uint64_t>& two) {
                    return big ? two[0] << 32 | two[1] : two[1] << 32 | two[0];
                };
                fields[273].value = both(offsets);
                fields[279].value = both(lengths);
            }
            if (perX > 0) {
                fields[282] = {5, 1, ratiosAt};
                fields[283] = {5, 1, ratiosAt + 8};
                fields[296] = {3, 1, unit};
            }
            if (!palette.empty())
                fields[320] = {3, palette.size(), paletteAt};
            if (!description.empty())
                fields[270] = {2, description.size() + 1, textAt};
            for (const auto& [tag, value] : other)
                fields[tag] = {4, 1, value};
            std::string next;
            append(next, file.size(), pointer);
            file.replace(nextAt, pointer, next);
            append(file, fields.size(), isLong ? 8 : 2);
            for (const auto& [tag, field] : fields) {
                append(file, static_cast<std::uint64_t>(tag), 2);
                append(file, static_cast<std::uint64_t>(field.type), 2);
                append(file, field.count, pointer);
                const bool isPointer = field.count * (field.type == 3   ? 2u
                                                      : field.type == 2 ? 1u
                                                                        : 4u) >
                                       pointer;
                const std::size_t size = isPointer || field.count > 1 ? pointer : field.type == 3 ? 2 : 4;
                append(file, field.value, size);
                file += std::string(pointer - size, '\0');
            }
            nextAt = file.size();
            append(file, 0, pointer);
        }
        return file;
    }

  private:
    void append(std::string& to, std::uint64_t value, std::size_t count) const {
        for (std::size_t i = 0; i < count; ++i)
            to += static_cast<char>(value >> 8 * (big ? count - 1 - i : i));
    }
};

OwnTiff ownTiff() {
    OwnTiff tiff;
    tiff.pixels = voxelBytes(stackValues<std::uint16_t>(5, 6, 3));
    return tiff;
}

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
    expectRefusal("cf=99\n", "found \"function 99\"");
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
    EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), HasSubstr("one channel"));
    write("ImageJ=1.53t\nimages=3\nslices=3\nunit=mm\nspacing=1\n", 4);
    EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), HasSubstr("3 pages"));
    write(R"(<OME><Pixels SizeC="2" SizeT="1" SizeZ="1"/></OME>)");
    EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), HasSubstr("one channel"));
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

TEST(ImportStack, WhatIsNoSliceIsRefused) {
    const ScratchFolder folder;
    const auto expectRefusal = [&](const std::map<int, std::uint32_t>& other, const char* what) {
        OwnTiff tiff = ownTiff();
        tiff.other = other;
        writeFile(folder / "a.tif", tiff.bytes());
        EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), AllOf(HasSubstr("a.tif"), HasSubstr(what)));
    };
    expectRefusal({{262, 0}}, "0 is white");
    expectRefusal({{262, 3}}, "palette");
    expectRefusal({{274, 3}}, "Orientation 3");
    expectRefusal({{258, 12}}, "12 bits");
    expectRefusal({{258, 1}}, "1 bits");
    expectRefusal({{277, 3}, {262, 2}}, "3 channels (red, green, blue)");
    expectRefusal({{259, 4}}, "compression 4");
    expectRefusal({{339, 6}}, "SampleFormat 6");
    writeFile(folder / "one.tif", OwnTiff{.pages = 1, .pixels = std::string(60, 'x')}.bytes());
    EXPECT_THAT(refusalOfOpening(folder / "one.tif", kCubes), HasSubstr("the name of a folder of slices"));
    const auto expectPngRefusal = [&](int channels, const char* what) {
        const ScratchFolder pngs;
        for (const char* name : {"p1.png", "p2.png"})
            writeByOiio<std::uint8_t>(pngs / name, {.channels = channels});
        EXPECT_THAT(refusalOfOpening(pngs.path(), kCubes), AllOf(HasSubstr("p1.png"), HasSubstr(what)));
        EXPECT_THAT(refusalOfOpening(pngs / "p1.png"), HasSubstr("opened by their folder"));
    };
    expectPngRefusal(2, "grey and opacity");
    expectPngRefusal(3, "red, green, blue");
    expectPngRefusal(4, "opacity");
}

TEST(ImportStack, ASliceOfAnotherSizeOrTypeIsNamed) {
    const ScratchFolder folder;
    const auto rewrite = [&](const OiioSpec& third, bool isWide) {
        for (int z = 1; z <= 4; ++z)
            writeByOiio<std::uint8_t>(folder / ("s" + std::to_string(z) + ".tif"), {}, 1, z);
        if (isWide)
            writeByOiio<std::uint16_t>(folder / "s3.tif", third, 1, 3);
        else
            writeByOiio<std::uint8_t>(folder / "s3.tif", third, 1, 3);
    };
    rewrite({.width = 36}, false);
    EXPECT_THAT(refusalOfOpening(folder.path(), kCubes),
                AllOf(HasSubstr("s3.tif"), HasSubstr("36x45 pixels of uint8")));
    rewrite({}, true);
    EXPECT_THAT(refusalOfOpening(folder.path(), kCubes), AllOf(HasSubstr("s3.tif"), HasSubstr("uint16")));
    rewrite({}, false);
    EXPECT_EQ(openSource(folder.path(), kCubes)->info().extentVoxels.z, 4);
    std::string cut(100, '\0');
    std::ifstream(folder / "s4.tif", std::ios::binary).read(cut.data(), 100);
    writeFile(folder / "s4.tif", cut); // the last one: no gap tells of it
    EXPECT_THAT(refusalOfOpening(folder.path(), kCubes), HasSubstr("s4.tif"));
}

TEST(ImportStack, LyingTiffFilesAreRefusedBeforeAnythingIsAllocated) {
    const ScratchFolder folder;
    const auto expectRefusal = [&](const std::string& bytes, const char* what) {
        writeFile(folder / "a.tif", bytes);
        EXPECT_THAT(refusalOfOpening(folder / "a.tif", kCubes), AllOf(HasSubstr("a.tif"), HasSubstr(what)));
    };
    const auto with = [&](const std::map<int, std::uint32_t>& other) {
        OwnTiff tiff = ownTiff();
        tiff.other = other;
        return tiff.bytes();
    };
    expectRefusal(with({{256, 0x7fffffff}, {257, 0x7fffffff}}), "places and lengths");
    expectRefusal(with({{256, 0x7fffffff}}), "too short for its pixels");
    expectRefusal(with({{256, 0xffffffff}}), "2^31");
    expectRefusal(with({{257, 0}}), "at least one pixel");
    expectRefusal(with({{278, 0}}), "a row a strip");
    expectRefusal(with({{278, 6}, {273, 1u << 30}, {279, 60}}), "behind its end");
    expectRefusal(with({{278, 6}, {273, 8}, {279, 59}}), "too short");
    expectRefusal(with({{278, 6}, {273, 8}, {279, 1u << 30}}), "behind its end");
    expectRefusal(with({{322, 1u << 16}, {323, 1u << 16}, {324, 8}, {325, 60}}), "row of tiles");
    expectRefusal(with({{322, 16}, {323, 16}, {324, 8}, {325, 1}}), "too short");
    std::string looped = ownTiff().bytes();
    // The last page points back to the first.
    looped.replace(looped.size() - 4, 4, looped.substr(4, 4));
    expectRefusal(looped, "points back");
    const std::string whole = ownTiff().bytes();
    for (std::size_t n = 0; n < whole.size(); ++n) {
        writeFile(folder / "cut.tif", whole.substr(0, n));
        ASSERT_THAT(refusalOfOpening(folder / "cut.tif", kCubes), HasSubstr("cut.tif")) << n;
    }
}

void expectHarmless(const fs::path& path, const SourceOptions& options) {
    try {
        const auto source = openSource(path, options);
        ASSERT_LT(source->info().voxelCount(), 1u << 22);
        std::vector<std::byte> out(bytesPerValue(source->info().type) * source->info().voxelCount());
        source->readSlices(source->info().extentVoxels.z, out);
    } catch (const InputError&) {
    }
}

TEST(ImportStack, RandomDamageIsAnErrorOrRead) {
    const ScratchFolder folder;
    std::mt19937 random(4711);
    const std::string own = ownTiff().bytes();
    std::vector<std::string> files = {own};
    for (const char* compression : {"lzw", "zip", "packbits"})
        for (const int tile : {0, 16}) {
            writeByOiio<std::uint16_t>(folder / "w.tif", {.compression = compression, .tile = tile}, 2);
            std::string bytes(fs::file_size(folder / "w.tif"), '\0');
            std::ifstream(folder / "w.tif", std::ios::binary)
                .read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
            files.push_back(bytes);
        }
    for (int n = 0; n < 700; ++n) {
        std::string bytes = files[static_cast<std::size_t>(n) % files.size()];
        for (std::size_t i = 0; i < 1 + random() % 4; ++i)
            bytes[random() % bytes.size()] = static_cast<char>(random());
        writeFile(folder / "d.tif", bytes);
        expectHarmless(folder / "d.tif", kCubes);
    }
}

TEST(ImportStack, DamagedAndLyingPngFilesAreRefused) {
    const ScratchFolder folder;
    for (const char* name : {"p1.png", "p2.png"})
        writeByOiio<std::uint16_t>(folder / name, {.width = 20, .height = 20});
    std::string whole(fs::file_size(folder / "p2.png"), '\0');
    std::ifstream(folder / "p2.png", std::ios::binary)
        .read(whole.data(), static_cast<std::streamsize>(whole.size()));
    const auto refused = [&](const std::string& bytes) {
        writeFile(folder / "p2.png", bytes);
        return refusal([&] { readAll<std::uint16_t>(*openSource(folder.path(), kCubes)); });
    };
    for (std::size_t n = 0; n < whole.size(); ++n)
        ASSERT_THAT(refused(whole.substr(0, n)), HasSubstr("p2.png")) << n;
    std::string huge = whole;
    huge.replace(16, 8, std::string("\x7f\xff\xff\xff\x7f\xff\xff\xff", 8));
    for (const char* name : {"p1.png", "p2.png"})
        writeFile(folder / name, huge);
    EXPECT_THAT(refusalOfOpening(folder.path(), kCubes), HasSubstr("too few"));
    writeByOiio<std::uint16_t>(folder / "p1.png", {.width = 20, .height = 20});
    std::string damaged = whole;
    damaged[damaged.find("IDAT") + 20] ^= 0x10; // no checksum fits it any more
    EXPECT_THAT(refused(damaged), AllOf(HasSubstr("p2.png"), HasSubstr("checksums")));
    std::mt19937 random(4711);
    for (int n = 0; n < 300; ++n) {
        std::string bytes = whole;
        for (std::size_t i = 0; i < 1 + random() % 4; ++i)
            bytes[random() % bytes.size()] = static_cast<char>(random());
        writeFile(folder / "p2.png", bytes);
        expectHarmless(folder.path(), kCubes);
    }
}

/// Of this process, MiB.
double mostResident() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmHWM:"))
            return std::stod(line.substr(6)) / 1024;
    return 0;
}

// A slice of 72 MiB in one strip: rows are read some at a time.
TEST(ImportStack, MemoryIsThatOfSomeRows) {
    const ScratchFolder folder;
    for (const char* compression : {"none", "zip"})
        for (const int tile : {0, 256}) {
            constexpr int kSide = 6144;
            const OIIO::ImageSpec spec = [&] {
                OIIO::ImageSpec out(kSide, kSide, 1, OIIO::TypeDesc::UINT16);
                out.attribute("compression", compression);
                out.attribute("tiff:RowsPerStrip", kSide);
                out.tile_width = out.tile_height = tile;
                return out;
            }();
            std::vector<std::uint16_t> pixels(std::size_t{kSide} * kSide);
            for (std::size_t i = 0; i < pixels.size(); ++i)
                pixels[i] = static_cast<std::uint16_t>(i / 4096);
            for (const char* name : {"s1.tif", "s2.tif"}) {
                const auto out = OIIO::ImageOutput::create("a.tif");
                ASSERT_TRUE(out->open((folder / name).string(), spec) &&
                            out->write_image(OIIO::TypeDesc::UINT16, pixels.data()) && out->close());
            }
            std::vector<std::uint16_t> slice(pixels.size(), 1);
            std::ofstream("/proc/self/clear_refs") << "5"; // VmHWM begins anew
            const double before = mostResident();
            const auto source = openSource(folder.path(), kCubes);
            source->readSlices(1, std::as_writable_bytes(std::span(slice)));
            EXPECT_LT(mostResident() - before, 32) << compression << tile;
            EXPECT_EQ(slice, pixels) << compression << tile;
        }
}

} // namespace
} // namespace tessera::test

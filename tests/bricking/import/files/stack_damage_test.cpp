// tests/bricking/import/files/stack_damage_test.cpp: stacks of pictures that are none, lie, or are damaged;
// and memory that a slice's size does not decide.
#include "bricking/import/files/stack/picture_walk.h"
#include "tests/support/stack_writers.h"

#include <functional>
#include <gmock/gmock.h>
#include <random>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

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

// What packed pixels may unpack to: 4096 bytes of 12 bits by LZW, 128 of 2 by PackBits, 1032 of one by
// deflate.
TEST(ImportStack, PackedTiffHasBytesEnoughForItsPixels) {
    const ScratchFolder folder;
    const auto outcome = [&](const std::map<int, std::uint32_t>& other) -> std::string {
        OwnTiff tiff;
        tiff.width = 60, tiff.height = tiff.rows = 30, tiff.pages = 1;
        tiff.pixels = std::string(3600, 'x');
        tiff.other = other;
        writeFile(folder / "a.tif", tiff.bytes());
        try {
            const PictureHead head = walkTiff(InputFile(folder / "a.tif"));
            return (head.isLossy ? "lossy " : "") + std::to_string(head.tileRows);
        } catch (const InputError& error) {
            return error.what();
        }
    };
    for (const auto& [coding, ratio, taken] :
         std::vector<std::tuple<std::uint32_t, std::uint32_t, const char*>>{{1, 1, "0"},
                                                                            {5, 2731, "0"},
                                                                            {8, 1032, "0"},
                                                                            {32946, 1032, "0"},
                                                                            {32773, 64, "0"},
                                                                            {7, 10000, "lossy 0"},
                                                                            {34925, 100000, "0"},
                                                                            {50000, 100000, "0"}}) {
        const auto of = [&, c = coding](std::uint32_t width) {
            return outcome({{256, width}, {257, 1}, {278, 1}, {259, c}, {273, 8}, {279, 10}});
        };
        EXPECT_EQ(of(5 * ratio), taken) << coding;
        EXPECT_THAT(of(5 * ratio + 1), HasSubstr(std::to_string(5 * ratio + 1) +
                                                 "x1 pixels, found a part of 10 bytes, too short"))
            << coding;
    }
    for (const std::uint32_t coding : {0u, 2u, 3u, 4u, 6u, 9u})
        EXPECT_THAT(outcome({{259, coding}}), HasSubstr("found compression " + std::to_string(coding)))
            << coding;
    // A row of tiles has 256 MiB at most, of tiles that reach beyond the picture too.
    const auto tiled = [&](std::uint32_t width, std::uint32_t across, std::uint32_t down) {
        return outcome(
            {{256, width}, {257, 30}, {259, 50000}, {322, across}, {323, down}, {324, 8}, {325, 3600}});
    };
    EXPECT_EQ(tiled(60, 16384, 8192), "8192");
    EXPECT_THAT(tiled(60, 16384, 8193),
                HasSubstr("a row of tiles of 256 MiB at most, found tiles of 16384x8193 pixels"));
    EXPECT_EQ(tiled(16384, 16384, 8192), "8192");
    EXPECT_THAT(tiled(16385, 16384, 8192), HasSubstr("a row of tiles of 256 MiB at most"));
    EXPECT_THAT(tiled(60, 0, 16), HasSubstr("tiles of 0x16 pixels"));
    EXPECT_THAT(tiled(60, 16, 0), HasSubstr("tiles of 16x0 pixels"));
    EXPECT_THAT(tiled(60, 16, 16),
                HasSubstr("8 places and lengths of pixels, as the page's size says, found 1 and 1"));
    EXPECT_THAT(outcome({{278, 29}}), HasSubstr("2 places and lengths of pixels"));
    EXPECT_EQ(outcome({{278, 31}}), "0") << "more rows a strip than there are";
}

TEST(ImportStack, ResolutionsOfTiffHaveAUnit) {
    const ScratchFolder folder;
    for (const auto& [unit, mm] : {std::pair(1u, 0.0), {2u, 25.4}, {3u, 10.0}, {4u, 0.0}}) {
        OwnTiff tiff = ownTiff();
        tiff.perX = 300, tiff.perY = 150, tiff.unit = unit;
        writeFile(folder / "a.tif", tiff.bytes());
        const PictureHead head = walkTiff(InputFile(folder / "a.tif"));
        ASSERT_TRUE(head.perUnit);
        EXPECT_EQ(*head.perUnit, glm::dvec2(300, 150));
        EXPECT_EQ(head.unitMm, mm) << unit;
        EXPECT_EQ(head.pages, 3);
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
#ifdef __SANITIZE_ADDRESS__ // it keeps freed memory for a while
constexpr double kMostMiB = 64;
#else
constexpr double kMostMiB = 32;
#endif
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
            EXPECT_LT(mostResident() - before, kMostMiB) << compression << tile;
            EXPECT_EQ(slice, pixels) << compression << tile;
        }
}

} // namespace
} // namespace tessera::test

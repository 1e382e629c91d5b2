// tests/bricking/import/files/stack_jpeg2000_test.cpp: stacks of JPEG 2000 pictures: every number of bits in
// both kinds of file, what is no slice, and damage.
#include "tests/support/stack_writers.h"
#include "tests/support/stream_writer.h"

#include <gmock/gmock.h>
#include <random>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kWidth = 37, kHeight = 45;

std::vector<std::int32_t> samplesOf(int z, const Jpeg2000Options& options) {
    std::vector<std::int32_t> samples;
    const int range = 1 << options.bits;
    for (const std::int32_t value : sliceValues<std::int32_t>(kWidth, kHeight, z))
        samples.push_back((29 * value & (range - 1)) - (options.isSigned ? range / 2 : 0));
    return samples;
}

std::string streamOf(int z, const Jpeg2000Options& options) {
    return encodeJpeg2000(samplesOf(z, options), kWidth, kHeight, options);
}

std::string big(std::uint64_t number, std::size_t bytes) {
    std::string text;
    for (std::size_t i = bytes; i-- > 0;)
        text += static_cast<char>(number >> (8 * i) & 255);
    return text;
}
std::string box(const std::string& kind, const std::string& content) {
    return big(content.size() + 8, 4) + kind + content;
}

struct Jp2 {
    std::string stream;
    std::uint64_t width = kWidth, height = kHeight, colours = 17;
    std::string header = {}; // further boxes of it
    bool isLast = false;     // the codestream: its box says no length

    std::string bytes() const {
        const std::string size = big(height, 4) + big(width, 4) + big(1, 2) + "\x0f\x07" + big(0, 2);
        return box("jP  ", "\r\n\x87\n") + box("ftyp", "jp2 " + big(0, 4) + "jp2 ") +
               box("jp2h", box("ihdr", size) + box("colr", "\1" + big(0, 2) + big(colours, 4)) + header) +
               (isLast ? big(0, 4) + "jp2c" + stream : box("jp2c", stream) + box("uuid", "more"));
    }
};

template <class Out> void expectSamples(ValueType type, const Jpeg2000Options& options) {
    std::vector<Out> expected;
    for (int z = 0; z < 3; ++z)
        for (const std::int32_t sample : samplesOf(z, options))
            expected.push_back(static_cast<Out>(sample));
    for (const bool isFramed : {false, true}) {
        const ScratchFolder folder;
        for (int z = 0; z < 3; ++z) {
            const std::string name = "s" + std::to_string(9 + z) + (isFramed ? ".jp2" : ".j2k");
            const std::string stream = streamOf(z, options);
            writeFile(folder / name, isFramed ? Jp2{.stream = stream, .isLast = z == 1}.bytes() : stream);
        }
        const auto source = openSource(folder.path(), kCubes);
        EXPECT_EQ(source->info().extentVoxels, glm::ivec3(kWidth, kHeight, 3));
        EXPECT_FALSE(source->info().lossy);
        EXPECT_EQ(source->info().type, type);
        EXPECT_EQ(readAll<Out>(*source), expected) << options.bits << options.isSigned << options.tile;
    }
}

TEST(ImportJpeg2000Stack, EveryNumberOfBitsReadsBackEqual) {
    for (const int tile : {0, 16}) {
        expectSamples<std::uint8_t>(ValueType::u8, {.bits = 8, .tile = tile});
        expectSamples<std::int16_t>(ValueType::i16, {.bits = 8, .isSigned = true, .tile = tile});
        for (const int bits : {9, 12, 16}) {
            expectSamples<std::uint16_t>(ValueType::u16, {.bits = bits, .tile = tile});
            expectSamples<std::int16_t>(ValueType::i16, {.bits = bits, .isSigned = true, .tile = tile});
        }
    }
    expectSamples<std::uint16_t>(ValueType::u16, {.bits = 12, .layers = 3, .packetMarkers = true});
}

// A writer that does not know it yet leaves the last tile-part's length 0.
TEST(ImportJpeg2000Stack, TheLastTilePartMayGoToTheEnd) {
    const ScratchFolder folder;
    std::string stream = streamOf(0, {.bits = 12});
    stream.replace(stream.find("\xff\x90") + 6, 4, std::string(4, '\0'));
    for (const char* name : {"s1.j2k", "s2.j2k"})
        writeFile(folder / name, stream);
    const auto source = openSource(folder.path(), kCubes);
    const std::vector<std::int32_t> samples = samplesOf(0, {.bits = 12});
    const std::vector<std::uint16_t> read = readAll<std::uint16_t>(*source);
    EXPECT_TRUE(std::equal(samples.begin(), samples.end(), read.begin()));
    writeFile(folder / "s2.j2k", stream.substr(0, stream.size() - 1));
    EXPECT_THAT(refusalOfOpening(folder.path(), kCubes), HasSubstr("truncated"));
}

TEST(ImportJpeg2000Stack, LossyStreamsAreSaid) {
    const ScratchFolder folder;
    for (int z = 0; z < 2; ++z)
        writeFile(folder / ("s" + std::to_string(z) + ".j2c"),
                  streamOf(z, {.bits = 12, .reversible = false}));
    EXPECT_TRUE(openSource(folder.path(), kCubes)->info().lossy);
}

// The resolution of capture, in pixels a metre: 50000 x 25000.
TEST(ImportJpeg2000Stack, ResolutionsAreSaidButNotOfSlices) {
    const ScratchFolder folder;
    const std::string both = big(25, 2) + big(1, 2) + big(500, 2) + big(1, 2) + "\3\2";
    for (int z = 0; z < 2; ++z)
        writeFile(folder / ("s" + std::to_string(z) + ".jp2"),
                  Jp2{.stream = streamOf(z, {}), .header = box("res ", box("resd", both) + box("resc", both))}
                      .bytes());
    EXPECT_THAT(refusalOfOpening(folder.path()),
                AllOf(HasSubstr("0.02 x 0.04 mm within slices"), HasSubstr("--spacing")));
}

TEST(ImportJpeg2000Stack, WhatIsNoSliceIsRefused) {
    const ScratchFolder folder;
    const auto expectRefusal = [&](const std::string& bytes, const char* what) {
        for (const char* name : {"s1.jp2", "s2.jp2"})
            writeFile(folder / name, bytes);
        EXPECT_THAT(refusalOfOpening(folder.path(), kCubes), AllOf(HasSubstr("s1.jp2"), HasSubstr(what)));
    };
    const std::string good = streamOf(0, {.bits = 12});
    for (const std::string& alone : {good, Jp2{.stream = good}.bytes()}) {
        writeFile(folder / "s1.jp2", alone);
        EXPECT_THAT(refusalOfOpening(folder / "s1.jp2"), HasSubstr("opened by their folder"));
    }
    expectRefusal(streamOf(0, {.bits = 8, .components = 3}), "3 channels");
    expectRefusal(streamOf(0, {.bits = 7}), "8 to 16 bits");
    expectRefusal(Jp2{.stream = good, .colours = 16}.bytes(), "colour space 16");
    expectRefusal(Jp2{.stream = good, .header = box("pclr", "x")}.bytes(), "a palette of colours");
    expectRefusal(Jp2{.stream = good, .width = 38}.bytes(), "38x45 and 37x45");
    expectRefusal(Jp2{.stream = good}.bytes() + box("jp2c", good), "several");
    expectRefusal(Jp2{.stream = ""}.bytes(), "s1.jp2");
    expectRefusal(box("jP  ", "\r\n\x87\n") + box("ftyp", "jp2 "), "a JPEG 2000 codestream");
    std::string lying = good; // its size: 16384 x 4097
    lying.replace(8, 8, big(16384, 4) + big(4097, 4));
    expectRefusal(lying, "2^26 pixels at most, found 16384x4097");
    lying.replace(8, 8, big(0x7fffffff, 4) + big(0x7fffffff, 4));
    expectRefusal(lying, "65535 pixels");
    for (const char* name : {"s1.jp2", "s2.jp2"})
        writeFile(folder / name, good);
    EXPECT_EQ(openSource(folder.path(), kCubes)->info().extentVoxels.z, 2);
    writeFile(folder / "s2.jp2", streamOf(0, {.bits = 16}));
    EXPECT_EQ(openSource(folder.path(), kCubes)->info().type, ValueType::u16); // both are held in 16 bits
    writeFile(folder / "s2.jp2", streamOf(0, {.bits = 12, .isSigned = true}));
    EXPECT_THAT(refusalOfOpening(folder.path(), kCubes), AllOf(HasSubstr("s2.jp2"), HasSubstr("int16")));
    fs::remove(folder / "s2.jp2");
    writeByOiio<std::uint16_t>(folder / "s2.png", {});
    EXPECT_THAT(refusalOfOpening(folder.path(), kCubes), HasSubstr("(JPEG 2000)"));
}

TEST(ImportJpeg2000Stack, CutAndDamagedFilesAreErrorsOrRead) {
    const ScratchFolder folder;
    for (const bool isFramed : {false, true}) {
        const std::string stream = streamOf(0, {.bits = 12}),
                          whole = isFramed ? Jp2{.stream = stream, .isLast = true}.bytes() : stream;
        for (const char* name : {"s1.jp2", "s2.jp2"})
            writeFile(folder / name, whole);
        for (std::size_t n = 0; n < whole.size(); ++n) {
            writeFile(folder / "s2.jp2", whole.substr(0, n));
            ASSERT_THAT(refusalOfOpening(folder.path(), kCubes), HasSubstr("s2.jp2")) << n;
        }
        std::mt19937 random(4711);
        for (int n = 0; n < 200; ++n) {
            std::string bytes = whole;
            const std::size_t range = n % 2 ? bytes.size() : 200; // headers most of all
            for (std::size_t i = 0; i < 1 + random() % 3; ++i)
                bytes[random() % range] = static_cast<char>(random());
            writeFile(folder / "s2.jp2", bytes);
            expectHarmless(folder.path(), kCubes);
        }
    }
}

} // namespace
} // namespace tessera::test

// tests/bricking/import/stream_values_test.cpp: samples of compressed DICOM pixels against their tags,
// without a file: signs, widths, overshoot, shapes, and the runs of RLE.
#include "bricking/import/codecs/stream.h"
#include "bricking/import/dicom/dicom_pixels.h"
#include "tests/support/import_test_tools.h"

#include <functional>
#include <gmock/gmock.h>
#include <optional>
#include <span>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

/// Samples of a stream as stored values: what is read, how many are clamped, and what is said.
TEST(StreamValues, SignAndPrecisionOfStreamsAndTags) {
    struct Given {
        int bits;
        std::optional<bool> isSigned; // of the stream
        bool isLossy;
        int stored;
        bool hasSign; // by the tags
    };
    const auto fitted = [](const Given& given, std::vector<std::int32_t> values) {
        StreamHeader stream;
        stream.bits = given.bits, stream.isSigned = given.isSigned, stream.lossy = given.isLossy;
        DicomSlice slice;
        slice.file = "folder/f";
        slice.bitsStored = given.stored, slice.isSigned = given.hasSign;
        StreamFindings findings;
        fitToTags(stream, slice, values, findings);
        EXPECT_EQ(findings.lossy, given.isLossy);
        std::string text;
        for (const std::int32_t value : values)
            text += (text.empty() ? "" : " ") + std::to_string(value);
        if (findings.clamped > 0)
            text += " clamped " + std::to_string(findings.clamped);
        if (!findings.disagreement.empty())
            text += " " + findings.disagreement;
        return text;
    };
    const std::string asIs = "; read as the stream says";
    const Given exact{12, false, false, 12, false}, lossy{12, false, true, 12, false};
    EXPECT_EQ(fitted(exact, {0, 7, 4095}), "0 7 4095");
    EXPECT_EQ(fitted(lossy, {0, 4095}), "0 4095");
    EXPECT_EQ(fitted(lossy, {-1, 0, 4095, 4096, 9999}), "0 0 4095 4095 4095 clamped 3");
    EXPECT_EQ(fitted(exact, {0, 4096}),
              "0 4096 f: the compressed stream says unsigned 12 bits, the tags say unsigned 12 bits" + asIs);
    // Fewer bits than the tags say are said, and do no harm.
    EXPECT_EQ(fitted({10, false, false, 12, false}, {0, 1023}),
              "0 1023 f: the compressed stream says unsigned 10 bits, the tags say unsigned 12 bits" + asIs);
    // Signed words that were compressed as unsigned ones: only so do they fit the tags.
    const std::string signsDiffer =
        " f: the compressed stream says unsigned 12 bits, the tags say signed 12 bits" + asIs;
    EXPECT_EQ(fitted({12, false, false, 12, true}, {0, 2047, 2048, 4095}), "0 2047 -2048 -1" + signsDiffer);
    EXPECT_EQ(fitted({12, false, false, 12, true}, {0, 2047}), "0 2047" + signsDiffer);
    EXPECT_EQ(fitted({12, true, false, 12, false}, {-1, 5}),
              "4095 5 f: the compressed stream says signed 12 bits, the tags say unsigned 12 bits" + asIs);
    // A lossy stream overshoots by a sixteenth of the range and one at most.
    const std::string wider =
        " f: the compressed stream says unsigned 14 bits, the tags say signed 12 bits" + asIs;
    EXPECT_EQ(fitted({14, false, true, 12, true}, {0, 2303}), "0 2047 clamped 1" + wider);
    EXPECT_EQ(fitted({14, false, true, 12, true}, {0, 2304}), "0 2304" + wider);
    // Streams without a sign hold words, masked or with their sign in every bit.
    EXPECT_EQ(fitted({16, {}, false, 12, true}, {0, 0x7FF, 0x800, 0xFFF}), "0 2047 -2048 -1");
    EXPECT_EQ(fitted({16, {}, false, 12, true}, {0, 0x7FF, 0xF800, 0xFFFF}), "0 2047 -2048 -1");
    EXPECT_EQ(fitted({12, {}, false, 12, false}, {0, 4095}), "0 4095");
    EXPECT_EQ(fitted({10, {}, false, 12, true}, {0, 511}),
              "0 511 f: the compressed stream says signed 10 bits, the tags say signed 12 bits" + asIs);
    EXPECT_THAT(refusal([&] {
                    fitted({10, {}, false, 12, true}, {0, 512});
                }),
                HasSubstr("expected a stream of 12 bits for signed pixels, found 10 bits"));
    // 8 and 16 bits from end to end.
    EXPECT_EQ(fitted({8, {}, false, 8, true}, {0, 127, 128, 255}), "0 127 -128 -1");
    EXPECT_EQ(fitted({16, {}, false, 16, true}, {0, 32767, 32768, 65535}), "0 32767 -32768 -1");
    EXPECT_EQ(fitted({16, true, true, 16, true}, {-32769, -32768, 32767, 32768}),
              "-32768 -32768 32767 32767 clamped 2");
}

TEST(StreamValues, ShapesAreCompared) {
    StreamHeader stream;
    stream.columns = 4, stream.rows = 3, stream.components = 1;
    DicomSlice slice;
    slice.file = "f", slice.columns = 4, slice.rows = 3;
    EXPECT_NO_THROW(checkShape(stream, slice));
    const std::string expected =
        "f: expected a compressed image of 4 x 3, as its tags say, found a stream of ";
    stream.components = 3;
    EXPECT_EQ(refusal([&] { checkShape(stream, slice); }), expected + "4 x 3, 3 components");
    stream.components = 1, stream.columns = 3, stream.rows = 4;
    EXPECT_EQ(refusal([&] { checkShape(stream, slice); }), expected + "3 x 4");
    stream.columns = 4;
    EXPECT_EQ(refusal([&] { checkShape(stream, slice); }), expected + "4 x 4");
    stream.columns = 5, stream.rows = 3;
    EXPECT_EQ(refusal([&] { checkShape(stream, slice); }), expected + "5 x 3");
}

/// DICOM PS3.5, annex G: five samples, of one byte and of two, the higher ones first.
TEST(StreamValues, RleRunsAndLiterals) {
    const auto decoded =
        [](
            const std::vector<std::string>& segments, int bytes,
            const std::function<void(std::string&)>& change = [](std::string&) {}) -> std::string {
        std::string stream(64, '\0');
        put(stream, 0, static_cast<std::uint32_t>(segments.size()));
        for (std::size_t i = 0; i < segments.size(); ++i) {
            put(stream, 4 + 4 * i, static_cast<std::uint32_t>(stream.size()));
            stream += segments[i];
        }
        change(stream);
        std::vector<std::int32_t> out(5, 77);
        try {
            decodeRle(std::as_bytes(std::span(stream)), bytes, "f", out);
        } catch (const InputError& error) {
            return error.what();
        }
        std::string text;
        for (const std::int32_t value : out)
            text += (text.empty() ? "" : " ") + std::to_string(value);
        return text;
    };
    const std::string literal("\4abcde", 6), run("\xfcz", 2), mixed("\1xy\x80\xfez", 6); // 5, 5, and 2 + 3
    EXPECT_EQ(decoded({literal}, 1), "97 98 99 100 101");
    EXPECT_EQ(decoded({run}, 1), "122 122 122 122 122");
    EXPECT_EQ(decoded({mixed}, 1), "120 121 122 122 122");
    EXPECT_EQ(decoded({run, literal}, 2), "31329 31330 31331 31332 31333"); // 256 * 122 + 97 to 101
    EXPECT_EQ(decoded({run + "x"}, 1), "122 122 122 122 122") << "a byte that makes it even";
    EXPECT_EQ(decoded({run + std::string(9, '\0')}, 1), "122 122 122 122 122");
    EXPECT_THAT(decoded({run + "xy"}, 1),
                HasSubstr("RLE segments of 5 bytes each, found one with 2 bytes behind them"));
    EXPECT_THAT(decoded({std::string("\3abcd", 5)}, 1), HasSubstr("found one of 4"));
    EXPECT_THAT(decoded({std::string("\4abcd", 5)}, 1), HasSubstr("one that ends within a run"));
    EXPECT_THAT(decoded({std::string("\xfc", 1)}, 1), HasSubstr("one that ends within a run"));
    EXPECT_THAT(decoded({std::string("\xfbz", 2)}, 1), HasSubstr("one with more"));
    EXPECT_THAT(decoded({std::string("\5abcdef", 7)}, 1), HasSubstr("one with more"));
    EXPECT_THAT(decoded({run}, 2), HasSubstr("2 RLE segments, found 1"));
    EXPECT_THAT(decoded({run, run}, 1), HasSubstr("1 RLE segments, found 2"));
    EXPECT_THAT(decoded({run}, 1, [](std::string& s) { s.resize(63); }),
                HasSubstr("an RLE header of 64 bytes, found 63 bytes"));
    const auto place = [&](std::size_t at, std::uint32_t offset) {
        return decoded({run, run}, 2, [&](std::string& s) { put(s, at, offset); });
    };
    for (const std::uint32_t offset : {63u, 65u})
        EXPECT_THAT(place(4, offset), HasSubstr("segment 1 from " + std::to_string(offset) + " to 66"));
    EXPECT_THAT(place(8, 69), HasSubstr("within 68 bytes, found segment 1 from 64 to 69"));
    EXPECT_THAT(place(8, 63), HasSubstr("segment 1 from 64 to 63"));
}

} // namespace
} // namespace tessera::test

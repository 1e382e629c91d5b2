// tests/bricking/import/streams_test.cpp: compressed DICOM pixels. Every coding returns the encoded values,
// streams that disagree with their tags are read by their own header, and damage is refused.
#include "bricking/import/codecs/stream.h"
#include "bricking/import/dicom/dicom_pixels.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"
#include "tests/support/stream_writer.h"

#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <random>

namespace tessera::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kColumns = 40, kRows = 24;
const std::string kRle = "1.2.840.10008.1.2.5", kBaseline = "1.2.840.10008.1.2.4.50",
                  kExtended = "1.2.840.10008.1.2.4.51", kLossless = "1.2.840.10008.1.2.4.70",
                  kLs = "1.2.840.10008.1.2.4.80", kLsNear = "1.2.840.10008.1.2.4.81",
                  k2000 = "1.2.840.10008.1.2.4.90", k2000Lossy = "1.2.840.10008.1.2.4.91";

/// A round structure with noise, from 0 to 4095: what 12 bits hold, both ends reached.
std::vector<std::uint16_t> twelveBits() {
    std::vector<std::uint16_t> words;
    std::mt19937 random(7);
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x) {
            const double r = std::hypot(x - 19.5, (y - 11.5) * 1.5) / 20;
            const double value = r > 0.8 ? 20 : r > 0.6 ? 4095 : 1000 + 400 * std::sin(x * 0.7);
            words.push_back(static_cast<std::uint16_t>(
                std::clamp(value + static_cast<int>(random() % 41) - 20, 0.0, 4095.0)));
        }
    return words;
}
std::vector<std::int32_t> asNumbers(const std::vector<std::uint16_t>& words) {
    return {words.begin(), words.end()};
}

class Streams : public ::testing::Test {
  protected:
    static DicomImage image(const std::string& syntax, const std::string& stream) {
        DicomImage image;
        image.columns = kColumns;
        image.rows = kRows;
        image.bitsStored = 12;
        image.pixelRepresentation = 0;
        image.syntax = syntax;
        image.fragments = {stream};
        return image;
    }
    std::filesystem::path save(const DicomImage& image) {
        writeDicom(folder_ / "IM0001.dcm", image);
        return folder_ / "IM0001.dcm";
    }
    /// Values in HU, and what was noted while they were read.
    std::vector<std::int16_t> read(const DicomImage& image) {
        source_ = openSource(save(image), {});
        testing::internal::CaptureStderr();
        auto values = readAll<std::int16_t>(*source_);
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
        return values;
    }
    std::string refused(const DicomImage& image) {
        testing::internal::CaptureStderr();
        const std::string message = refusal([&] { readAll<std::int16_t>(*openSource(save(image), {})); });
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
        EXPECT_THAT(message, HasSubstr("IM0001.dcm"));
        return message;
    }
    static std::vector<std::int16_t> hu(const std::vector<std::uint16_t>& words) {
        std::vector<std::int16_t> values;
        for (const std::uint16_t word : words)
            values.push_back(static_cast<std::int16_t>(word - 1024));
        return values;
    }
    static int largestDifference(const std::vector<std::int16_t>& a, const std::vector<std::int16_t>& b) {
        int largest = 0;
        for (std::size_t i = 0; i < a.size(); ++i)
            largest = std::max(largest, std::abs(a[i] - b[i]));
        return largest;
    }

    const std::vector<std::uint16_t> words_ = twelveBits();
    const std::string lossless_ = encodeJpegLossless(words_, kColumns, kRows);
    const std::string ls_ = encodeJpegLs(words_, kColumns, kRows, 12);
    const std::string rle_ = encodeRle(words_);
    const std::string j2k_ = encodeJpeg2000(asNumbers(words_), kColumns, kRows, {.bits = 12});
    const ScratchFolder folder_;
    std::unique_ptr<SlabSource> source_;
};

TEST_F(Streams, LosslessCodingsGiveTheValuesThatWentIn) {
    for (const auto& [syntax, stream] :
         {std::pair(kRle, rle_), {kLossless, lossless_}, {kLs, ls_}, {k2000, j2k_}}) {
        EXPECT_EQ(read(image(syntax, stream)), hu(words_)) << syntax;
        EXPECT_FALSE(source_->info().lossy) << syntax;
        EXPECT_THAT(source_->notes(), IsEmpty()) << syntax;
    }
    for (const int predictor : {2, 3, 4, 5, 6, 7})
        EXPECT_EQ(read(image(kLossless, encodeJpegLossless(words_, kColumns, kRows, predictor))), hu(words_));
}

TEST_F(Streams, FragmentsOfOneFrameAreOneStream) {
    DicomImage cut = image(kLs, "");
    cut.fragments = {ls_.substr(0, 100), ls_.substr(100, 256), ls_.substr(356)};
    EXPECT_EQ(read(cut), hu(words_));
}

// Two frames, each in fragments: where they begin, only the table of offsets tells.
TEST_F(Streams, AFrameBeginsWhereTheTableOfOffsetsSays) {
    const std::vector<std::uint16_t> back(words_.rbegin(), words_.rend());
    const std::string other = encodeRle(back);
    DicomImage two = image(kRle, "");
    two.storageClass = "1.2.840.10008.5.1.4.1.1.2.1";
    two.frames = 2;
    two.framePositions = {{0, 0, 0}, {0, 0, 1}};
    two.fragments = {rle_.substr(0, 100), rle_.substr(100), other.substr(0, 200), other.substr(200, 50),
                     other.substr(250)};
    constexpr std::uint32_t kItemHeader = 8;
    two.fragmentOffsets = {0, 2 * kItemHeader + static_cast<std::uint32_t>((rle_.size() + 1) / 2 * 2)};
    std::vector<std::int16_t> expected = hu(words_);
    const std::vector<std::int16_t> second = hu(back);
    expected.insert(expected.end(), second.begin(), second.end());
    EXPECT_EQ(read(two), expected);
    two.fragmentOffsets[1] += 2;
    EXPECT_THAT(refused(two), HasSubstr("table of offsets"));
}

TEST_F(Streams, PlainWordsOfEitherByteOrder) {
    for (const char* syntax : {"1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2"}) {
        DicomImage plain = image(syntax, "");
        plain.fragments.clear();
        plain.pixels = words_;
        EXPECT_EQ(read(plain), hu(words_)) << syntax;
    }
}

TEST_F(Streams, SignedWordsWithMaskedOrExtendedSign) {
    std::vector<std::uint16_t> masked, extended;
    std::vector<std::int16_t> expected;
    std::vector<std::int32_t> numbers;
    for (const std::uint16_t word : words_) {
        const int value = word - 2048;
        masked.push_back(static_cast<std::uint16_t>(value & 0xfff));
        extended.push_back(static_cast<std::uint16_t>(value));
        expected.push_back(static_cast<std::int16_t>(value));
        numbers.push_back(value);
    }
    for (DicomImage signedImage :
         {image(kLs, encodeJpegLs(masked, kColumns, kRows, 12)),
          image(kLs, encodeJpegLs(masked, kColumns, kRows, 16)),
          image(kLossless, encodeJpegLossless(extended, kColumns, kRows)), image(kRle, encodeRle(extended)),
          image(k2000, encodeJpeg2000(numbers, kColumns, kRows, {.bits = 12, .isSigned = true}))}) {
        signedImage.pixelRepresentation = 1;
        signedImage.intercept = "0";
        EXPECT_EQ(read(signedImage), expected);
        EXPECT_THAT(source_->notes(), IsEmpty());
    }
}

// A signed stream under unsigned tags was decoded to garbage without a word.
TEST_F(Streams, Jpeg2000IsReadByItsOwnSignAndPrecision) {
    const auto stream = encodeJpeg2000(asNumbers(words_), kColumns, kRows, {.bits = 16, .isSigned = true});
    EXPECT_EQ(read(image(k2000, stream)), hu(words_));
    ASSERT_EQ(source_->notes().size(), 1u); // said once, though 12 of 16 bits would be no reason
    EXPECT_THAT(source_->notes().front(), HasSubstr("signed 16 bits"));
    EXPECT_THAT(source_->notes().front(), HasSubstr("unsigned 12 bits"));
    // An unsigned stream that holds the words of signed pixels: its own numbers would be beyond all tags.
    std::vector<std::int32_t> asWords;
    std::vector<std::int16_t> expected;
    for (const std::uint16_t word : words_) {
        asWords.push_back((word - 1024) & 0xffff);
        expected.push_back(static_cast<std::int16_t>(word - 1024));
    }
    DicomImage wrapped = image(k2000, encodeJpeg2000(asWords, kColumns, kRows, {.bits = 16}));
    wrapped.bitsStored = 16;
    wrapped.pixelRepresentation = 1;
    wrapped.intercept = "0";
    EXPECT_EQ(read(wrapped), expected);
    EXPECT_EQ(source_->notes().size(), 1u);
    // Fewer bits than the tags say, and the same numbers.
    DicomImage narrow = image(k2000, j2k_);
    narrow.bitsStored = 16;
    EXPECT_EQ(read(narrow), hu(words_));
    EXPECT_EQ(source_->notes().size(), 1u);
}

TEST_F(Streams, SizeOrCodingAgainstTheTagsIsRefusedWithBothValues) {
    for (const auto& [syntax, stream] : {std::pair(kLossless, lossless_), {kLs, ls_}, {k2000, j2k_}}) {
        DicomImage wide = image(syntax, stream);
        wide.columns = kColumns + 2;
        const std::string message = refused(wide);
        EXPECT_THAT(message, HasSubstr("42 x 24")) << syntax;
        EXPECT_THAT(message, HasSubstr("40 x 24")) << syntax;
    }
    DicomImage wide = image(kRle, rle_);
    wide.columns = kColumns + 2;
    EXPECT_THAT(refused(wide), HasSubstr("1008"));
    EXPECT_THAT(refused(image(kLossless, ls_)), HasSubstr("JPEG-LS"));
    EXPECT_THAT(refused(image(k2000, lossless_)), HasSubstr("JPEG"));
    EXPECT_THAT(refused(image(kLs, j2k_)), HasSubstr("JPEG 2000"));
    DicomImage ambiguous = image(kLs, ls_); // are 12-bit words above 2047 negative?
    ambiguous.bitsStored = 16;
    ambiguous.pixelRepresentation = 1;
    EXPECT_THAT(refused(ambiguous), HasSubstr("12 bits"));
}

// Lossy streams overshoot: 4095 becomes 4100, which was cut to its lowest 12 bits, air amid metal.
TEST_F(Streams, LossyOvershootIsClampedCountedAndSaid) {
    struct Case {
        std::string syntax, stream;
        int tolerance;
    };
    const std::vector<Case> cases = {
        {k2000Lossy,
         encodeJpeg2000(asNumbers(words_), kColumns, kRows, {.bits = 16, .reversible = false, .ratio = 3}),
         200},
        {kLsNear, encodeJpegLs(words_, kColumns, kRows, 16, 9), 9},
        {kExtended, encodeJpegLossy12(words_, kColumns, kRows), 500}};
    for (const Case& c : cases) {
        DicomImage lossy = image(c.syntax, c.stream);
        lossy.lossy = "01";
        lossy.lossyRatio = "3.5\\6.25"; // twice compressed: the last one counts
        EXPECT_LE(largestDifference(read(lossy), hu(words_)), c.tolerance) << c.syntax;
        EXPECT_TRUE(source_->info().lossy) << c.syntax;
        EXPECT_EQ(source_->info().lossyRatio, 6.25) << c.syntax;
        if (c.syntax != kExtended) { // whose samples have 12 bits
            EXPECT_GT(source_->info().clampedVoxels, 0u) << c.syntax;
        }
    }
    // Said by the stream alone, and known before a slice is read.
    for (const Case& c : cases)
        EXPECT_TRUE(openSource(save(image(c.syntax, c.stream)), {})->info().lossy) << c.syntax;
    const auto shifted = encodeJpegLossless(words_, kColumns, kRows, 1, 2);
    EXPECT_LE(largestDifference(read(image(kLossless, shifted)), hu(words_)), 3);
    EXPECT_TRUE(source_->info().lossy);
}

// Values far outside the tags are no overshoot: the tags are wrong, and nothing is cut off.
TEST_F(Streams, ALossyStreamOfAnotherSignIsReadAsItIs) {
    std::vector<std::int32_t> values = asNumbers(words_);
    for (std::int32_t& value : values)
        value -= 3000;
    DicomImage lossy =
        image(k2000Lossy, encodeJpeg2000(values, kColumns, kRows,
                                         {.bits = 13, .isSigned = true, .reversible = false, .ratio = 3}));
    lossy.intercept = "0";
    const std::vector<std::int16_t> found = read(lossy), expected(values.begin(), values.end());
    EXPECT_LE(largestDifference(found, expected), 500); // the least is -3000
    EXPECT_EQ(source_->info().clampedVoxels, 0u);
    EXPECT_THAT(source_->notes(), ElementsAre(HasSubstr("the compressed stream says signed 13 bits")));
}

TEST_F(Streams, EightBitBaselineJpeg) {
    std::vector<std::uint16_t> narrow;
    for (const std::uint16_t word : words_)
        narrow.push_back(word >> 4);
    DicomImage lossy = image(kBaseline, encodeJpegLossy8(narrow, kColumns, kRows));
    lossy.bitsAllocated = lossy.bitsStored = 8;
    EXPECT_LE(largestDifference(read(lossy), hu(narrow)), 40);
    EXPECT_TRUE(source_->info().lossy);
}

TEST_F(Streams, TruncatedStreamsAreRefused) {
    for (const auto& [syntax, stream] :
         {std::pair(kRle, rle_), {kLossless, lossless_}, {kLs, ls_}, {k2000, j2k_}}) {
        for (const double part : {0.02, 0.3, 0.7, 0.98}) {
            const auto kept = static_cast<std::size_t>(part * static_cast<double>(stream.size()));
            refused(image(syntax, stream.substr(0, kept)));
            // The end marker alone makes no whole stream.
            if (syntax != kRle)
                refused(image(syntax, stream.substr(0, kept) + "\xff\xd9"));
        }
        refused(image(syntax, ""));
    }
}

/// The place of the first tile-part's length (Psot).
std::size_t tilePartLength(const std::string& stream) {
    return stream.find("\xff\x90") + 6;
}

/// A stream as some archives leave it: of its packets only the first ones are left, and its tile-part says
/// its old length. The markers before packets, which show where to cut, are taken out again.
std::string withFirstPackets(const std::vector<std::int32_t>& values, Jpeg2000Options options, int packets) {
    const std::string packetMarker("\xff\x91\x00\x04", 4);
    options.packetMarkers = true;
    std::string stream = encodeJpeg2000(values, kColumns, kRows, options);
    const std::size_t coding = stream.find(std::string("\xff\x52", 2));
    stream[coding + 4] = static_cast<char>(stream[coding + 4] & ~2);
    for (int packet = 0;; ++packet) {
        const std::size_t at = stream.find(packetMarker);
        if (packet == packets)
            return stream.substr(0, at) + "\xff\xd9";
        stream.erase(at, 6);
    }
}

TEST_F(Streams, ATileThatIsNotThereIsNamed) {
    std::string stream = j2k_;
    const std::size_t tile = tilePartLength(stream) - 2;
    stream[tile] = 0, stream[tile + 1] = 7;
    EXPECT_THAT(refused(image(k2000, stream)), HasSubstr("with tiles 0 to 0, found 7"));
}

TEST_F(Streams, TilePartOfAnotherLengthIsMendedOnlyIfTheLargestValueProvesIt) {
    std::string stream = j2k_;
    stream[tilePartLength(stream) + 3] = static_cast<char>(stream[tilePartLength(stream) + 3] + 9);
    DicomImage damaged = image(k2000, stream);
    EXPECT_THAT(refused(damaged), HasSubstr("tile-part 0 says"));
    damaged.largestPixel = *std::max_element(words_.begin(), words_.end());
    EXPECT_EQ(read(damaged), hu(words_));
    ASSERT_EQ(source_->notes().size(), 1u);
    EXPECT_THAT(source_->notes().front(), HasSubstr("tile-part 0 says"));
    damaged.largestPixel = *damaged.largestPixel - 1;
    EXPECT_THAT(refused(damaged), HasSubstr("largest pixel value"));
}

TEST_F(Streams, StrippedQualityLayersOfASignedStreamUnderUnsignedTags) {
    const Jpeg2000Options options{.bits = 16, .isSigned = true, .layers = 4}; // of 4 packets each
    DicomImage stripped = image(k2000, withFirstPackets(asNumbers(words_), options, 12));
    EXPECT_THAT(refused(stripped), HasSubstr("tile-part"));
    stripped.largestPixel = 4000;
    const std::string message = refused(stripped);
    ASSERT_THAT(message, HasSubstr("largest pixel value of 4000"));
    stripped.largestPixel = std::stoi(message.substr(message.find("found ") + 6));
    EXPECT_LE(largestDifference(read(stripped), hu(words_)), 400);
    EXPECT_TRUE(source_->info().lossy); // three layers of four
    EXPECT_EQ(source_->notes().size(), 2u);
}

TEST_F(Streams, WarningsOfADecoderAreErrors) {
    std::string unknown = j2k_; // an unknown marker, skipped with a warning
    unknown.insert(unknown.find(std::string("\xff\x52", 2)), std::string("\xff\x7a\x00\x04\x01\x02", 6));
    refused(image(k2000, unknown));
    std::string extra = lossless_; // bytes that no sample needs, before the end marker
    extra.insert(extra.size() - 2, std::string(40, '\x55'));
    refused(image(kLossless, extra));
}

TEST_F(Streams, RestartMarkersCount) {
    const std::size_t scan = lossless_.find(std::string("\xff\xda", 2)) + 10;
    std::string counted = lossless_.substr(0, scan);
    for (const char* part : {"ab\xff\xd0", "cd\xff\xd1", "ef\xff\xd9"})
        counted += part;
    EXPECT_NO_THROW(walkJpeg(bytesOf(counted), "x"));
    counted[counted.find("\xff\xd1") + 1] = '\xd2'; // one is lost
    EXPECT_THAT(refusal([&] { walkJpeg(bytesOf(counted), "x"); }), HasSubstr("restart marker 1"));
}

TEST_F(Streams, RleSegmentsGiveExactlyTheirBytes) {
    const auto segment = [](const std::string& high, const std::string& low) {
        std::string stream(64, '\0');
        stream[0] = 2;
        stream[4] = 64;
        stream[8] = static_cast<char>(64 + high.size());
        return stream + high + low;
    };
    const std::string run8("\xf9\x07", 2), run7("\xfa\x07", 2); // eight and seven bytes of 7
    std::vector<std::int32_t> out(8);
    EXPECT_NO_THROW(decodeRle(bytesOf(segment(run8, run8)), 2, "x", out));
    EXPECT_EQ(out, std::vector<std::int32_t>(8, 0x0707));
    EXPECT_THAT(refusal([&] { decodeRle(bytesOf(segment(run8, run7)), 2, "x", out); }),
                HasSubstr("one of 7"));
    EXPECT_THAT(refusal([&] { decodeRle(bytesOf(segment(run8, run8 + run8)), 2, "x", out); }),
                HasSubstr("2 bytes behind"));
    EXPECT_THAT(refusal([&] { decodeRle(bytesOf(segment(run8, run7 + run7)), 2, "x", out); }),
                HasSubstr("one with more"));
    EXPECT_THAT(refusal([&] { decodeRle(bytesOf(segment(run8, run8)), 1, "x", out); }), HasSubstr("found 2"));
}

TEST_F(Streams, SignedOvershootIsClampedNotWrapped) {
    std::vector<std::uint16_t> words(words_.size());
    for (std::size_t i = 0; i < words.size(); ++i) // 2047 beside what nears it, signs extended to 16 bits
        words[i] = static_cast<std::uint16_t>(i % 3 ? 2047 - static_cast<int>(i % 5)
                                                    : -2048 + static_cast<int>(i % 7));
    DicomImage lossy = image(kLsNear, encodeJpegLs(words, kColumns, kRows, 16, 6));
    lossy.pixelRepresentation = 1;
    lossy.intercept = "0";
    const auto values = read(lossy);
    for (std::size_t i = 0; i < words.size(); ++i)
        ASSERT_NEAR(values[i], static_cast<std::int16_t>(words[i]), 6) << i;
    EXPECT_GT(source_->info().clampedVoxels, 0u);
}

// The parser reads beyond the end of such a file.
TEST_F(Streams, AFileThatEndsInItsEndMarkIsRefused) {
    for (const auto& [syntax, stream] :
         {std::pair(kRle, rle_), {kLossless, lossless_}, {kLs, ls_}, {k2000, j2k_}})
        for (const int left : {1, 2, 4, 6, 8}) {
            const std::string bytes = dicomBytes(image(syntax, stream));
            writeFile(folder_ / "IM0001.dcm", bytes.substr(0, bytes.size() - static_cast<std::size_t>(left)));
            EXPECT_THAT(refusal([&] { openSource(folder_ / "IM0001.dcm", {}); }), HasSubstr("IM0001.dcm"));
        }
}

/// A DICOM file whose data set is one raw deflate stream, with what follows it.
std::string deflated(const DicomImage& plain, bool gzipTrailer, const std::string& behind) {
    DicomImage image = plain;
    image.syntax = "1.2.840.10008.1.2.1.99";
    const std::string bytes = dicomBytes(image);
    std::uint32_t metaBytes = 0;
    std::memcpy(&metaBytes, bytes.data() + 140, 4);
    const std::string dataSet = bytes.substr(144 + metaBytes);
    const std::string packed = gzip(dataSet); // a header of ten bytes, the stream, checksum and size
    return bytes.substr(0, 144 + metaBytes) + packed.substr(10, packed.size() - 10 - (gzipTrailer ? 0 : 8)) +
           behind;
}

// GDCM leaves the checksum and the size behind the stream.
TEST_F(Streams, DeflatedDataSetsWithAndWithoutATrailer) {
    DicomImage plain = image("", "");
    plain.fragments.clear();
    plain.pixels = words_;
    const auto path = folder_ / "IM0001.dcm";
    for (const bool trailer : {false, true}) {
        writeFile(path, deflated(plain, trailer, ""));
        EXPECT_EQ(readAll<std::int16_t>(*openSource(path, {})), hu(words_)) << trailer;
    }
    std::string damaged = deflated(plain, true, "");
    damaged[damaged.size() - 6] = static_cast<char>(damaged[damaged.size() - 6] ^ 1); // in the checksum
    writeFile(path, damaged);
    EXPECT_THAT(refusalOfOpening(path), HasSubstr("nothing behind the deflated data set"));
    writeFile(path, deflated(plain, false, "more"));
    EXPECT_THAT(refusalOfOpening(path), HasSubstr("nothing behind the deflated data set"));
}

// 2 MiB that inflate to 2 GiB took 512 MiB before they were refused.
TEST_F(Streams, ADeflateBombTakesLittleMemory) {
    DicomImage plain = image("", "");
    plain.fragments.clear();
    plain.pixels = words_;
    plain.syntax = "1.2.840.10008.1.2.1.99";
    const std::string bytes = dicomBytes(plain);
    std::uint32_t metaBytes = 0;
    std::memcpy(&metaBytes, bytes.data() + 140, 4);
    const auto raw = [](const std::string& text, int flush) { // the deflate stream of a text
        z_stream stream{};
        deflateInit2(&stream, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY);
        std::string out(compressBound(text.size()) + 64, '\0');
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
        stream.avail_in = static_cast<uInt>(text.size());
        stream.next_out = reinterpret_cast<Bytef*>(out.data());
        stream.avail_out = static_cast<uInt>(out.size());
        deflate(&stream, flush);
        out.resize(stream.total_out);
        deflateEnd(&stream);
        return out;
    };
    const std::string megabyte = raw(std::string(1 << 20, 'x'), Z_FULL_FLUSH); // stands for itself anywhere
    std::string bomb = bytes.substr(0, 144 + metaBytes) + raw(bytes.substr(144 + metaBytes), Z_FULL_FLUSH);
    for (int i = 0; i < 2048; ++i)
        bomb += megabyte;
    const auto path = folder_ / "IM0001.dcm";
    writeFile(path, bomb + raw("", Z_FINISH));
    bomb.clear();
    const auto mostBytes = [] { // of the process, so far
        std::ifstream status("/proc/self/status");
        std::size_t kilobytes = 0;
        for (std::string line; std::getline(status, line);)
            if (line.rfind("VmHWM:", 0) == 0)
                kilobytes = std::stoul(line.substr(6));
        return kilobytes << 10;
    };
    std::ofstream("/proc/self/clear_refs") << "5"; // begins the count anew, where that may be
    const std::size_t before = mostBytes();
    EXPECT_THAT(refusalOfOpening(path), HasSubstr("at most 512 MiB"));
    EXPECT_LT(mostBytes() - before, std::size_t{32} << 20);
    // A large one that is none is read by parts.
    DicomImage large = plain;
    large.columns = large.rows = 3000;
    large.pixels.assign(9000000, 7);
    large.pixels.back() = 1234;
    writeFile(path, deflated(large, false, ""));
    EXPECT_EQ(readAll<std::int16_t>(*openSource(path, {})).back(), 1234 - 1024);
}

// An element out of order in one slice is damage, in all slices a writer's habit.
TEST_F(Streams, IrregularHeadersAreJudgedByTheSeries) {
    const auto save = [&](int odd, int slices = 5) {
        std::filesystem::remove_all(folder_ / "series");
        for (int z = 0; z < slices; ++z) {
            DicomImage slice = image("1.2.840.10008.1.2.1", "");
            slice.fragments.clear();
            slice.pixels = words_;
            slice.position = glm::dvec3(0, 0, z);
            std::string bytes = dicomBytes(slice);
            if (z < odd) // the kernel's tag (0018,1210), behind (0018,0060), becomes (0018,0010)
                bytes[bytes.find(std::string("\x18\x00\x10\x12SH", 6)) + 3] = '\0';
            std::filesystem::create_directories(folder_ / "series");
            writeFile(folder_ / "series" / ("IM" + std::to_string(z)), bytes);
        }
        return folder_ / "series";
    };
    EXPECT_THAT(openSource(save(0), {})->notes(), IsEmpty());
    EXPECT_THAT(refusalOfOpening(save(1)), HasSubstr("IM0: expected a header without fault"));
    EXPECT_THAT(refusalOfOpening(save(2)), HasSubstr("(0018,0010)"));
    EXPECT_THAT(refusalOfOpening(save(2, 4)), HasSubstr("as most slices of its series have")) << "just half";
    const auto habit = openSource(save(5), {});
    ASSERT_EQ(habit->notes().size(), 1u);
    EXPECT_THAT(habit->notes().front(), HasSubstr("irregular headers"));
}

// Every bit of a short stretch, and bytes all over: what is not refused must be what the stream holds.
TEST_F(Streams, DamageNeverCrashes) {
    std::mt19937 random(11);
    int accepted = 0, tried = 0;
    for (const auto& [syntax, stream] :
         {std::pair(kRle, rle_), {kLossless, lossless_}, {kLs, ls_}, {k2000, j2k_}})
        for (int n = 0; n < 60; ++n, ++tried) {
            std::string damaged = stream;
            const std::size_t at =
                random() % (n % 2 ? std::min<std::size_t>(damaged.size(), 120) : damaged.size());
            damaged[at] = static_cast<char>(n % 3 ? damaged[at] ^ (1 << random() % 8) : random());
            try {
                readAll<std::int16_t>(*openSource(save(image(syntax, damaged)), {}));
                ++accepted;
            } catch (const InputError&) {
            }
        }
    RecordProperty("accepted", accepted);
    EXPECT_LT(accepted, tried * 3 / 4);
}

/// Findings and refusals too: those of the first slice that has them.
TEST_F(Streams, SeveralAtOnceAreThoseOfOneAfterAnother) {
    const std::vector<std::uint16_t> words = twelveBits();
    const auto readBy = [&](int threads) {
        auto source = openSource(folder_.path(), {});
        source->setThreads(threads);
        return std::pair{readAll<std::int16_t>(*source), std::move(source)};
    };
    for (const bool isLs : {false, true}) {
        const auto streamOf = [&](int n) {
            std::vector<std::uint16_t> own = words;
            std::rotate(own.begin(), own.begin() + n, own.end());
            return isLs ? encodeJpegLs(own, kColumns, kRows, 12)
                        : encodeJpeg2000(asNumbers(own), kColumns, kRows, {.bits = 12});
        };
        const auto write = [&](int n, const std::string& stream) {
            DicomImage slice = image(isLs ? kLs : k2000, stream);
            slice.position = glm::dvec3(0, 0, 2 * n);
            slice.slope = "9"; // 4095 becomes more than 32767
            writeDicom(folder_ / ("IM" + std::to_string(1000 + n) + ".dcm"), slice);
        };
        for (int n = 0; n < 11; ++n)
            write(n, streamOf(n));
        const auto [one, oneSource] = readBy(1);
        EXPECT_GT(oneSource->info().clampedVoxels, 0u);
        for (const int threads : {2, 4}) {
            const auto [several, source] = readBy(threads);
            EXPECT_TRUE(several == one);
            EXPECT_EQ(source->info().clampedVoxels, oneSource->info().clampedVoxels);
            EXPECT_EQ(source->notes(), oneSource->notes());
        }
        for (const int n : {8, 6, 4}) {
            write(n, streamOf(n).substr(0, 400));
            const std::string first = refusal([&] { readBy(1); });
            EXPECT_THAT(first, HasSubstr("IM" + std::to_string(1000 + n)));
            for (int time = 0; time < 5; ++time)
                EXPECT_EQ(refusal([&] { readBy(4); }), first);
        }
    }
}

} // namespace
} // namespace tessera::test

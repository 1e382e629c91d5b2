// bricking/import/files/stack/jpeg2000_walk.cpp: walkJpeg2000Picture() and openJpeg2000Rows() of
// picture_walk.h. Rules: ITU-T T.800, annexes A (codestream) and I (JP2).
#include "bricking/import/codecs/stream.h"
#include "bricking/import/files/stack/picture_walk.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <vector>

namespace tessera {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kJp2Mark = "\0\0\0\x0cjP  \r\n\x87\n"sv, kStreamMark = "\xff\x4f\xff\x51"sv;
constexpr int kLeastBits = 8;
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 26; // decoding takes 8 bytes of each

std::uint64_t bigNumber(std::span<const std::byte> bytes) {
    std::uint64_t number = 0;
    for (const std::byte byte : bytes)
        number = number << 8 | std::to_integer<std::uint64_t>(byte);
    return number;
}

struct Range {
    std::uint64_t at = 0, end = 0;
};

class Jpeg2000Walk {
  public:
    explicit Jpeg2000Walk(const InputFile& file) : file_(file) { head_.shape.format = kJpeg2000; }

    PictureHead walk() {
        std::array<char, kJp2Mark.size()> mark{};
        file_.readSome(0, std::as_writable_bytes(std::span(mark)));
        const std::string_view begin(mark.data(), mark.size());
        if (begin == kJp2Mark)
            walkBoxes({0, file_.sizeBytes()}, false);
        else
            stream_ = {0, file_.sizeBytes()};
        if (stream_.end == 0)
            refuse("a JPEG 2000 codestream", "none (is it truncated?)");
        walkStream();
        return head_;
    }
    Range stream() const { return stream_; }

  private:
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(file_.path().string(), expected, found);
    }
    std::uint64_t number(std::uint64_t at, std::size_t count, std::uint64_t end) const {
        std::array<std::byte, 8> bytes{};
        if (at > end || count > end - at || file_.readSome(at, std::span(bytes).first(count)) < count)
            refuse("a whole JPEG 2000 file", "the end of the file (is it truncated?)");
        return bigNumber(std::span(bytes).first(count));
    }

    /// Of the file, or of its header.
    void walkBoxes(Range in, bool isHeader) {
        while (in.at < in.end) {
            const std::uint64_t said = number(in.at, 4, in.end), kind = number(in.at + 4, 4, in.end);
            std::uint64_t length = said, frame = 8;
            if (said == 1)
                length = number(in.at + 8, 8, in.end), frame = 16;
            if (said == 0) // to the end
                length = in.end - in.at;
            if (length < frame || length > in.end - in.at)
                refuse("JPEG 2000 boxes within the file", "one of " + std::to_string(length) +
                                                              " bytes at byte " + std::to_string(in.at) +
                                                              " (is it truncated?)");
            takeBox(static_cast<std::uint32_t>(kind), {in.at + frame, in.at + length}, isHeader);
            in.at += length;
        }
    }

    static constexpr std::uint32_t named(std::string_view name) {
        std::uint32_t kind = 0;
        for (const char c : name)
            kind = kind << 8 | static_cast<unsigned char>(c);
        return kind;
    }

    void takeBox(std::uint32_t kind, Range box, bool isHeader) {
        if (kind == named("jp2h") && !isHeader) {
            walkBoxes(box, true);
        } else if (kind == named("jp2c") && !isHeader) {
            if (stream_.end != 0)
                refuse("a slice: one codestream", "several");
            stream_ = box;
        } else if (kind == named("ihdr") && isHeader) {
            said_ = glm::ivec2(number(box.at + 4, 4, box.end) & kMostSide,
                               number(box.at, 4, box.end) & kMostSide);
        } else if (kind == named("colr") && isHeader) {
            constexpr std::uint64_t kEnumerated = 1, kGrey = 17;
            if (number(box.at, 1, box.end) == kEnumerated && number(box.at + 3, 4, box.end) != kGrey)
                refuse("grey values where 0 is black",
                       "colour space " + std::to_string(number(box.at + 3, 4, box.end)));
        } else if (kind == named("pclr") && isHeader) {
            refuse("a picture of one channel (grey)", "a palette of colours");
        } else if (kind == named("res ") && isHeader) {
            takeResolution(box);
        }
    }

    /// That of capture: pixels a metre.
    void takeResolution(Range in) {
        constexpr std::uint64_t kFrame = 8, kLength = 18;
        for (; in.end - in.at >= kLength; in.at += kLength) {
            if (number(in.at, 4, in.end) != kLength || number(in.at + 4, 4, in.end) != named("resc"))
                continue;
            const auto ratio = [&](std::uint64_t at, std::uint64_t exponent) {
                const auto power = static_cast<std::int8_t>(number(exponent, 1, in.end));
                return static_cast<double>(number(at, 2, in.end)) /
                       static_cast<double>(number(at + 2, 2, in.end)) * std::pow(10.0, power);
            };
            const std::uint64_t at = in.at + kFrame;
            head_.perUnit = glm::dvec2(ratio(at + 4, at + 9), ratio(at, at + 8));
            constexpr double kMetre = 1000;
            head_.unitMm = kMetre;
        }
    }

    void walkStream() {
        const std::uint64_t bytes = stream_.end - stream_.at;
        std::optional<StreamHeader> header;
        std::vector<std::byte> beginning;
        // Segments of text and of lengths may be long.
        for (std::uint64_t portion = 1 << 12; !header && beginning.size() < bytes && portion <= 1 << 24;
             portion <<= 4) {
            beginning.resize(std::min(portion, bytes));
            file_.readAt(stream_.at, beginning);
            header = peekHeader(StreamCoding::jpeg2000, beginning);
        }
        if (!header)
            throwWhatIsWrong(beginning);
        if (header->components != 1)
            refuse("a picture of one channel (grey)", std::to_string(header->components) + " channels");
        if (header->bits < kLeastBits)
            refuse("8 to 16 bits a pixel", std::to_string(header->bits));
        if (static_cast<std::uint64_t>(header->columns) * static_cast<std::uint64_t>(header->rows) >
            kMostPixels)
            refuse("a JPEG 2000 picture of 2^26 pixels at most",
                   std::to_string(header->columns) + "x" + std::to_string(header->rows));
        head_.shape.size = {header->columns, header->rows};
        if (said_ && *said_ != head_.shape.size)
            refuse("one size of the picture", std::to_string(said_->x) + "x" + std::to_string(said_->y) +
                                                  " and " + std::to_string(header->columns) + "x" +
                                                  std::to_string(header->rows));
        const bool isSigned = header->isSigned.value_or(false);
        head_.shape.type = header->bits == kLeastBits ? (isSigned ? FileType::i8 : FileType::u8)
                                                      : (isSigned ? FileType::i16 : FileType::u16);
        head_.isLossy = header->lossy;
        walkTileParts(beginning);
    }

    [[noreturn]] void throwWhatIsWrong(std::span<const std::byte> beginning) const {
        walkJpeg2000(beginning, file_.path().string());
        refuse("the header of a JPEG 2000 codestream", "none in its first 16 MiB");
    }

    /// By the lengths that they say, up to the end marker.
    void walkTileParts(std::span<const std::byte> beginning) const {
        constexpr std::uint64_t kTilePart = 0xFF90, kEnd = 0xFFD9;
        std::uint64_t at = 2;
        const auto inBeginning = [&](std::uint64_t from, std::size_t count) {
            return bigNumber(beginning.subspan(from, count));
        };
        while (inBeginning(at, 2) != kTilePart) // peekHeader() has been here
            at += 2 + inBeginning(at + 2, 2);
        at += stream_.at;
        while (number(at, 2, stream_.end) == kTilePart) {
            const std::uint64_t length = number(at + 6, 4, stream_.end);
            constexpr std::uint64_t kLeast = 14;
            if (length == 0) { // up to the end marker; bytes behind it would be packets
                at = stream_.end - 2;
                break;
            }
            if (length < kLeast || length > stream_.end - at)
                refuse("tile-parts within the file",
                       "one of " + std::to_string(length) + " bytes (is it truncated?)");
            at += length;
        }
        if (number(at, 2, stream_.end) != kEnd)
            refuse("an end marker of the JPEG 2000 codestream",
                   "none at byte " + std::to_string(at) + " (is it truncated?)");
    }

    static constexpr std::uint64_t kMostSide = std::numeric_limits<std::int32_t>::max();
    const InputFile& file_;
    PictureHead head_;
    Range stream_;
    std::optional<glm::ivec2> said_; // size, in the header of JP2
};

/// All of a picture, decoded with the first rows.
class Jpeg2000Rows final : public PictureRows {
  public:
    Jpeg2000Rows(const std::filesystem::path& path, const PictureShape& shape) : shape_(shape) {
        const InputFile file(path);
        const std::string where = path.string();
        Jpeg2000Walk walk(file);
        const PictureHead head = walk.walk();
        if (head.shape.size != shape.size || head.shape.type != shape.type)
            throw badFile(where, "the picture that was there before", "another");
        std::vector<std::byte> stream(walk.stream().end - walk.stream().at);
        file.readAt(walk.stream().at, stream);
        const StreamHeader header = walkJpeg2000(stream, where);
        if (!header.damage.empty())
            throw badFile(where, "tile-parts of the stated length", header.damage);
        samples_.resize(static_cast<std::size_t>(shape.size.x) * static_cast<std::size_t>(shape.size.y));
        decodeJpeg2000(stream, header, where, samples_);
    }

    void read(int page, int first, int count, std::span<std::byte> out) override {
        const std::size_t bytes = bytesPerFileValue(shape_.type);
        const auto width = static_cast<std::size_t>(shape_.size.x);
        TESSERA_CHECK(page == 0 && out.size() == static_cast<std::size_t>(count) * width * bytes);
        const std::span<const std::int32_t> rows = std::span(samples_).subspan(
            static_cast<std::size_t>(first) * width, static_cast<std::size_t>(count) * width);
        for (std::size_t i = 0; i < rows.size(); ++i) { // the low bytes, whatever the sign
            const auto low = static_cast<std::uint16_t>(rows[i]);
            const auto lowest = static_cast<std::uint8_t>(rows[i]);
            std::memcpy(out.data() + i * bytes, bytes == 1 ? static_cast<const void*>(&lowest) : &low, bytes);
        }
    }

  private:
    PictureShape shape_;
    std::vector<std::int32_t> samples_;
};

} // namespace

bool beginsAsJpeg2000(const InputFile& file) {
    std::array<char, kJp2Mark.size()> mark{};
    const std::size_t got = file.readSome(0, std::as_writable_bytes(std::span(mark)));
    const std::string_view begin(mark.data(), got);
    return begin == kJp2Mark || begin.starts_with(kStreamMark);
}

PictureHead walkJpeg2000Picture(const InputFile& file) {
    return Jpeg2000Walk(file).walk();
}

std::unique_ptr<PictureRows> openJpeg2000Rows(const std::filesystem::path& file, const PictureShape& shape) {
    return std::make_unique<Jpeg2000Rows>(file, shape);
}

} // namespace tessera

// bricking/import/files/stack/tiff_walk.cpp: walkTiff() of picture_walk.h. Rules: TIFF 6.0 and BigTIFF.
#include "bricking/import/files/stack/picture_walk.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>
#include <vector>

namespace tessera {
namespace {

enum Tag : int {
    kWidth = 256,
    kHeight = 257,
    kBits = 258,
    kCompression = 259,
    kPhotometric = 262,
    kDescription = 270,
    kStripOffsets = 273,
    kOrientation = 274,
    kSamples = 277,
    kRowsPerStrip = 278,
    kStripBytes = 279,
    kPerX = 282,
    kPerY = 283,
    kResolutionUnit = 296,
    kPalette = 320,
    kTileWidth = 322,
    kTileHeight = 323,
    kTileOffsets = 324,
    kTileBytes = 325,
    kSampleFormat = 339
};

struct Coding {
    std::uint64_t number;
    double mostRatio; // of pixels' bytes to packed ones
    bool isLossy;
};
constexpr std::array kCodings = {
    Coding{1, 1, false},       Coding{5, 2731, false},     // LZW: 4096 bytes by 12 bits
    Coding{8, 1032, false},    Coding{32946, 1032, false}, // deflate
    Coding{32773, 64, false},                              // PackBits: 128 by 2
    Coding{7, 1e4, true},                                  // JPEG
    Coding{34925, 1e5, false}, Coding{50000, 1e5, false}}; // LZMA, zstd

constexpr std::uint64_t kMostEntries = 4096, kMostDescription = std::uint64_t{16} << 20;
constexpr double kMostTileBytes = 256 << 20; // of a row of tiles, which are read together

/// A field of a page. Its values are in the file at `at`.
struct Entry {
    int type = 0;
    std::uint64_t count = 0, at = 0;
};

class TiffWalk {
  public:
    explicit TiffWalk(const InputFile& file) : file_(file) {
        std::array<std::byte, 16> head{};
        if (file.readSome(0, head) < 8)
            refuse("a TIFF file", "the end of the file (is it truncated?)");
        isBig_ = head[0] == std::byte{'M'};
        const std::uint64_t version = numberIn(head, 2, 2);
        isLong_ = version == 43;
        if ((version != 42 && !isLong_) || (isLong_ && numberIn(head, 4, 2) != 8))
            refuse("a TIFF or BigTIFF file", "version " + std::to_string(version));
        next_ = isLong_ ? numberIn(head, 8, 8) : numberIn(head, 4, 4);
    }

    /// False behind the last page.
    bool toNextPage() {
        if (next_ == 0)
            return false;
        ++page_;
        if (!seen_.insert(next_).second)
            refuse("pages one after another", "a page that points back");
        entries_.clear();
        const std::uint64_t countBytes = isLong_ ? 8 : 2, entryBytes = isLong_ ? 20 : 12,
                            pointerBytes = isLong_ ? 8 : 4;
        const std::uint64_t entries = number(next_, countBytes);
        if (entries < 1 || entries > kMostEntries)
            refuse("1 to " + std::to_string(kMostEntries) + " fields", std::to_string(entries));
        std::vector<std::byte> bytes(entries * entryBytes + pointerBytes);
        if (next_ > file_.sizeBytes() || file_.readSome(next_ + countBytes, bytes) < bytes.size())
            refuse("the fields of a page", "the end of the file (is it truncated?)");
        for (std::uint64_t i = 0; i < entries; ++i) {
            const std::size_t at = i * entryBytes;
            Entry entry{static_cast<int>(numberIn(bytes, at + 2, 2)),
                        numberIn(bytes, at + 4, isLong_ ? 8 : 4),
                        next_ + countBytes + at + (isLong_ ? 12 : 8)};
            const std::uint64_t each = bytesOf(entry.type);
            if (each > 0 && entry.count > file_.sizeBytes() / each)
                refuse("fields within the file", "a field of " + std::to_string(entry.count) + " values");
            if (each * entry.count > pointerBytes)
                entry.at = numberIn(bytes, at + (isLong_ ? 12 : 8), pointerBytes);
            if (entry.at + each * entry.count > file_.sizeBytes() || entry.at > file_.sizeBytes())
                refuse("fields within the file", "one behind its end (is it truncated?)");
            if (!entries_.emplace(static_cast<int>(numberIn(bytes, at, 2)), entry).second)
                refuse("every field once", "field " + std::to_string(numberIn(bytes, at, 2)) + " again");
        }
        next_ = numberIn(bytes, entries * entryBytes, pointerBytes);
        return true;
    }
    bool isLastPage() const { return next_ == 0; }

    PictureHead head() {
        PictureHead head;
        head.bigEndian = isBig_;
        const std::uint64_t width = required(kWidth, "ImageWidth"), height = required(kHeight, "ImageLength");
        constexpr std::uint64_t kMostSide = std::numeric_limits<std::int32_t>::max();
        if (width < 1 || height < 1 || width > kMostSide || height > kMostSide)
            refuse("at least one pixel, and 2^31 along a side at most",
                   std::to_string(width) + "x" + std::to_string(height));
        head.shape.size = {static_cast<int>(width), static_cast<int>(height)};
        if (const std::uint64_t samples = single(kSamples, 1); samples != 1)
            refuse("a picture of one channel (grey)",
                   std::to_string(samples) + " channels" +
                       (single(kPhotometric, 1) == 2 ? " (red, green, blue)" : ""));
        const std::uint64_t photometric = single(kPhotometric, 1);
        head.shape.isPalette = photometric == 3 && isGreyPalette();
        if (photometric != 1 && !head.shape.isPalette)
            refuse("grey values where 0 is black",
                   photometric == 0   ? "values where 0 is white (PhotometricInterpretation 0)"
                   : photometric == 3 ? "a palette of colours"
                                      : "PhotometricInterpretation " + std::to_string(photometric));
        if (const std::uint64_t order = single(kOrientation, 1); order != 1)
            refuse("rows from the top, columns from the left", "Orientation " + std::to_string(order));
        head.shape.type = typeOf(single(kBits, 1), single(kSampleFormat, 1));
        head.isHalf = head.shape.type == FileType::f32 && single(kBits, 1) == 16;
        checkData(head);
        head.description = description();
        if (entry(kPerX) && entry(kPerY)) {
            head.perUnit = glm::dvec2(ratio(kPerX), ratio(kPerY));
            const std::uint64_t unit = single(kResolutionUnit, 2);
            head.unitMm = unit == 2 ? 25.4 : unit == 3 ? 10 : 0;
        }
        return head;
    }

    /// Of a page that may be no slice.
    std::string description() const {
        std::string text;
        if (const Entry* said = entry(kDescription); said && said->type == 2) {
            text.resize(std::min(said->count, kMostDescription));
            file_.readAt(said->at, std::as_writable_bytes(std::span(text)));
            text.resize(std::strlen(text.c_str()));
        }
        return text;
    }

    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(file_.path().string(),
                      (page_ > 1 ? "in page " + std::to_string(page_) + " " : "") + expected, found);
    }

  private:
    static std::uint64_t bytesOf(int type) {
        switch (type) {
        case 1:
        case 2:
        case 6:
        case 7:
            return 1;
        case 3:
        case 8:
            return 2;
        case 4:
        case 9:
        case 11:
        case 13:
            return 4;
        case 5:
        case 10:
        case 12:
        case 16:
        case 17:
        case 18:
            return 8;
        default:
            return 0; // unknown: never read
        }
    }
    std::uint64_t numberIn(std::span<const std::byte> bytes, std::size_t at, std::size_t count) const {
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < count; ++i)
            value = value << 8 | std::to_integer<std::uint64_t>(bytes[at + (isBig_ ? i : count - 1 - i)]);
        return value;
    }
    std::uint64_t number(std::uint64_t at, std::size_t count) const {
        std::array<std::byte, 8> bytes{};
        if (at > file_.sizeBytes() || file_.readSome(at, std::span(bytes).first(count)) < count)
            refuse("fields within the file", "the end of the file (is it truncated?)");
        return numberIn(bytes, 0, count);
    }
    const Entry* entry(int tag) const {
        const auto at = entries_.find(tag);
        return at == entries_.end() ? nullptr : &at->second;
    }
    std::uint64_t single(int tag, std::uint64_t fallback) const {
        const Entry* one = entry(tag);
        if (!one)
            return fallback;
        if ((one->type != 1 && one->type != 3 && one->type != 4 && one->type != 16) || one->count < 1)
            refuse("whole numbers in field " + std::to_string(tag), "type " + std::to_string(one->type));
        return number(one->at, bytesOf(one->type));
    }
    std::uint64_t required(int tag, const char* name) const {
        if (!entry(tag))
            refuse(std::string("the TIFF field ") + name, "none");
        return single(tag, 0);
    }
    double ratio(int tag) const {
        const Entry& one = *entry(tag);
        if (one.type != 5 || one.count != 1)
            return 0;
        return static_cast<double>(number(one.at, 4)) / static_cast<double>(number(one.at + 4, 4));
    }
    FileType typeOf(std::uint64_t bits, std::uint64_t format) const {
        struct Row {
            std::uint64_t bits, format;
            FileType type;
        };
        static constexpr std::array kTypes = {
            Row{8, 1, FileType::u8},   Row{8, 2, FileType::i8},   Row{16, 1, FileType::u16},
            Row{16, 2, FileType::i16}, Row{32, 1, FileType::u32}, Row{32, 2, FileType::i32},
            Row{16, 3, FileType::f32}, Row{32, 3, FileType::f32}, Row{64, 3, FileType::f64}};
        const auto* const row = std::find_if(
            kTypes.begin(), kTypes.end(), [&](const Row& r) { return r.bits == bits && r.format == format; });
        if (row == kTypes.end())
            refuse("whole numbers of 8, 16 or 32 bits, or floats of 16, 32 or 64 bits",
                   std::to_string(bits) + " bits of SampleFormat " + std::to_string(format));
        return row->type;
    }

    /// Values of a field of whole numbers, a portion after another: f(number).
    template <typename Each> void eachOf(const Entry& of, const Each& each) const {
        const std::size_t bytes = bytesOf(of.type);
        constexpr std::uint64_t kPortion = 8192; // values
        std::vector<std::byte> portion(std::min(of.count, kPortion) * bytes);
        for (std::uint64_t done = 0; done < of.count; done += kPortion) {
            const std::uint64_t now = std::min(kPortion, of.count - done);
            file_.readAt(of.at + done * bytes, std::span(portion).first(now * bytes));
            for (std::uint64_t i = 0; i < now; ++i)
                each(numberIn(portion, i * bytes, bytes));
        }
    }

    /// Of 8 bits: each entry is the grey of its number, by OpenImageIO's rounding too.
    bool isGreyPalette() const {
        constexpr std::uint64_t kEntries = 256;
        const Entry* const colours = entry(kPalette);
        if (!colours || colours->type != 3 || colours->count != 3 * kEntries || single(kBits, 1) != 8 ||
            single(kSampleFormat, 1) != 1)
            return false;
        bool isGrey = true;
        std::uint64_t n = 0;
        eachOf(*colours, [&](std::uint64_t colour) {
            isGrey = isGrey && colour == 257 * (n % kEntries); // all 16 bits
            ++n;
        });
        return isGrey;
    }

    /// All parts lie in the file, and are as long as the pixels in them need.
    void checkData(PictureHead& head) {
        const bool isTiled = entry(kTileWidth) || entry(kTileOffsets);
        const auto width = static_cast<std::uint64_t>(head.shape.size.x),
                   height = static_cast<std::uint64_t>(head.shape.size.y);
        const std::uint64_t bytes = single(kBits, 1) / 8; // half floats are floats only once they are read
        const std::uint64_t coding = single(kCompression, 1);
        const auto* const known = std::find_if(kCodings.begin(), kCodings.end(),
                                               [&](const Coding& c) { return c.number == coding; });
        if (known == kCodings.end())
            refuse("no compression, or LZW, deflate, PackBits, LZMA, zstd or JPEG",
                   "compression " + std::to_string(coding));
        head.isLossy = known->isLossy;
        std::uint64_t partWidth = width, partHeight = std::min(single(kRowsPerStrip, height), height);
        if (isTiled) {
            partWidth = required(kTileWidth, "TileWidth");
            partHeight = required(kTileHeight, "TileLength");
            const double across = std::ceil(static_cast<double>(width) /
                                            static_cast<double>(std::max<std::uint64_t>(partWidth, 1)));
            if (partWidth < 1 || partHeight < 1 ||
                across * static_cast<double>(partWidth) * static_cast<double>(partHeight) *
                        static_cast<double>(bytes) >
                    kMostTileBytes)
                refuse("a row of tiles of 256 MiB at most", "tiles of " + std::to_string(partWidth) + "x" +
                                                                std::to_string(partHeight) + " pixels");
            head.tileRows = static_cast<int>(partHeight);
        } else if (coding != 1) {
            head.stripRows = static_cast<int>(partHeight);
        }
        if (partHeight < 1)
            refuse("a row a strip at least", "RowsPerStrip 0");
        const std::uint64_t across = (width + partWidth - 1) / partWidth,
                            down = (height + partHeight - 1) / partHeight;
        const Entry* offsets = entry(isTiled ? kTileOffsets : kStripOffsets);
        const Entry* lengths = entry(isTiled ? kTileBytes : kStripBytes);
        const auto isWhole = [](const Entry* one) {
            return one && (one->type == 3 || one->type == 4 || one->type == 16);
        };
        if (!isWhole(offsets) || !isWhole(lengths))
            refuse("places and lengths of the pixels", "none");
        if (offsets->count != across * down || lengths->count != across * down)
            refuse(std::to_string(across * down) + " places and lengths of pixels, as the page's size says",
                   std::to_string(offsets->count) + " and " + std::to_string(lengths->count));
        std::vector<std::uint64_t> places; // a portion of lengths is compared with as many places
        places.reserve(across * down);     // at most what the file holds of them
        eachOf(*offsets, [&](std::uint64_t at) { places.push_back(at); });
        std::uint64_t part = 0, runEnd = places.front();
        bool isRun = known->number == 1 && !isTiled;
        eachOf(*lengths, [&](std::uint64_t length) {
            const std::uint64_t at = places[part];
            if (at > file_.sizeBytes() || length > file_.sizeBytes() - at)
                refuse("pixels within the file", "some behind its end (is it truncated?)");
            const std::uint64_t rows =
                isTiled ? partHeight : std::min(partHeight, height - part * partHeight);
            const double needed =
                static_cast<double>(partWidth) * static_cast<double>(rows) * static_cast<double>(bytes);
            if (needed > static_cast<double>(length) * known->mostRatio)
                refuse(std::to_string(width) + "x" + std::to_string(height) + " pixels",
                       "a part of " + std::to_string(length) + " bytes, too short for its pixels");
            isRun = isRun && at == runEnd;
            runEnd = at + length;
            ++part;
        });
        if (isRun)
            head.runOffset = places.front();
    }

    const InputFile& file_;
    bool isBig_ = false, isLong_ = false; // byte order; BigTIFF
    std::uint64_t next_ = 0;
    int page_ = 0;
    std::set<std::uint64_t> seen_;
    std::map<int, Entry> entries_;
};

} // namespace

bool beginsAsTiff(const InputFile& file) {
    std::array<char, 4> mark{};
    if (file.readSome(0, std::as_writable_bytes(std::span(mark))) < mark.size())
        return false;
    const std::string_view text(mark.data(), mark.size());
    using namespace std::string_view_literals;
    return text == "II*\0"sv || text == "MM\0*"sv || text == "II+\0"sv || text == "MM\0+"sv;
}

PictureHead walkTiff(const InputFile& file) {
    TiffWalk walk(file);
    if (!walk.toNextPage())
        walk.refuse("a page", "none");
    PictureHead head = walk.head();
    while (walk.toNextPage()) {
        const PictureHead next = walk.head();
        if (next.shape.size != head.shape.size || next.shape.type != head.shape.type)
            walk.refuse(std::to_string(head.shape.size.x) + "x" + std::to_string(head.shape.size.y) +
                            " pixels of " + name(head.shape.type) + ", as in the first",
                        std::to_string(next.shape.size.x) + "x" + std::to_string(next.shape.size.y) +
                            " pixels of " + name(next.shape.type));
        head.isLossy = head.isLossy || next.isLossy;
        head.shape.isPalette = head.shape.isPalette || next.shape.isPalette;
        head.tileRows = std::max(head.tileRows, next.tileRows);
        if (next.tileRows != head.tileRows)
            walk.refuse("tiles as in the first", "others");
        ++head.pages;
    }
    return head;
}

TiffBeginning tiffBeginningOf(const InputFile& file) {
    if (!beginsAsTiff(file))
        return {};
    TiffWalk walk(file);
    if (!walk.toNextPage())
        return {};
    return {!walk.isLastPage(), walk.description()};
}

} // namespace tessera

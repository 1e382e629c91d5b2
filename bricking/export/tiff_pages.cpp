// bricking/export/tiff_pages.cpp: see tiff_pages.h. Pixels first, then the directories of all pages, whose
// numbers are then known.
#include "bricking/export/tiff_pages.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <zlib.h>

namespace tessera {
namespace {

constexpr std::size_t kStripBytes = std::size_t{256} * 1024;
constexpr std::uint64_t kMostClassic = std::numeric_limits<std::uint32_t>::max() - 65536;
constexpr std::uint64_t kDirectoryBytes = 320; // at most, a page

enum TiffType : std::uint16_t { kAscii = 2, kShort = 3, kLong = 4, kRational = 5, kLong8 = 16 };

struct Rational {
    std::uint32_t above = 0, below = 1;
};

/// The nearest fraction whose numbers fit, by continued fractions.
Rational rationalOf(double value) {
    double rest = value;
    std::uint64_t above0 = 0, below0 = 1, above1 = 1, below1 = 0;
    constexpr int kMostTerms = 40;
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
    for (int term = 0; term < kMostTerms; ++term) {
        const double whole = std::floor(rest);
        if (!(whole <= static_cast<double>(kMost)))
            break;
        const auto w = static_cast<std::uint64_t>(whole);
        const std::uint64_t above = w * above1 + above0, below = w * below1 + below0;
        if (above > kMost || below > kMost)
            break;
        above0 = std::exchange(above1, above), below0 = std::exchange(below1, below);
        if (rest == whole)
            break;
        rest = 1 / (rest - whole);
    }
    return {static_cast<std::uint32_t>(above1),
            static_cast<std::uint32_t>(std::max<std::uint64_t>(below1, 1))};
}

/// One page's directory, entry by entry in ascending order of tags.
class Directory {
  public:
    explicit Directory(bool isBig) : isBig_(isBig), bytes_(isBig ? 8 : 2) {}

    /// A number in the entry itself.
    void number(std::uint16_t tag, TiffType type, std::uint64_t value) { entry(tag, type, 1, value); }
    /// Values elsewhere in the file.
    void elsewhere(std::uint16_t tag, TiffType type, std::uint64_t count, std::uint64_t offset) {
        entry(tag, type, count, offset);
    }
    void rational(std::uint16_t tag, Rational value, std::uint64_t offset) {
        // BigTIFF's entries hold eight bytes themselves.
        entry(tag, kRational, 1, isBig_ ? value.above | std::uint64_t{value.below} << 32 : offset);
    }
    std::vector<std::byte> finish(std::uint64_t next) {
        if (isBig_)
            std::memcpy(bytes_.data(), &entries_, 8);
        else
            std::memcpy(bytes_.data(), &entries_, 2);
        put(&next, isBig_ ? 8 : 4);
        return std::move(bytes_);
    }
    static std::uint64_t bytesOf(bool isBig, std::uint64_t entries) {
        return isBig ? 8 + 20 * entries + 8 : 2 + 12 * entries + 4;
    }

  private:
    void entry(std::uint16_t tag, TiffType type, std::uint64_t count, std::uint64_t value) {
        ++entries_;
        put(&tag, 2);
        const std::uint16_t typeNumber = type;
        put(&typeNumber, 2);
        put(&count, isBig_ ? 8 : 4);
        put(&value, isBig_ ? 8 : 4); // little-endian: a short number's bytes come first
    }
    void put(const void* value, std::size_t size) {
        const auto* const from = static_cast<const std::byte*>(value);
        bytes_.insert(bytes_.end(), from, from + size);
    }
    bool isBig_;
    std::vector<std::byte> bytes_;
    std::uint64_t entries_ = 0;
};

std::uint64_t sampleFormat(FileType type) {
    return type == FileType::f32 ? 3 : type == FileType::i16 ? 2 : 1;
}

int rowsPerStripOf(const TiffLayout& layout) {
    if (!layout.isPacked)
        return layout.size.y;
    const std::size_t rowBytes = static_cast<std::size_t>(layout.size.x) * bytesPerFileValue(layout.type);
    return static_cast<int>(
        std::clamp<std::size_t>(kStripBytes / rowBytes, 1, static_cast<std::size_t>(layout.size.y)));
}

bool needsBig(const TiffLayout& layout) {
    const std::uint64_t pixels = static_cast<std::uint64_t>(layout.size.x) *
                                 static_cast<std::uint64_t>(layout.size.y) *
                                 static_cast<std::uint64_t>(layout.pages) * bytesPerFileValue(layout.type);
    // What does not deflate grows by a thousandth, and each strip has sixteen bytes in the tables.
    const std::uint64_t strips =
        layout.isPacked ? pixels / 512 + static_cast<std::uint64_t>(layout.pages) * 64 : 0;
    return pixels + strips + static_cast<std::uint64_t>(layout.pages) * kDirectoryBytes > kMostClassic;
}

} // namespace

TiffPages::TiffPages(const std::filesystem::path& path, TiffLayout layout, Existing existing)
    : layout_(std::move(layout)), rowsPerStrip_(rowsPerStripOf(layout_)),
      isBig_(layout_.isBig || needsBig(layout_)), file_(path, existing) {
    constexpr std::string_view kClassic("II\x2a\0\0\0\0\0", 8),
        kBig("II\x2b\0\x08\0\0\0\0\0\0\0\0\0\0\0", 16);
    file_.append(isBig_ ? kBig : kClassic);
    pixelsBegin_ = file_.size();
    if (layout_.isPacked)
        strip_.reserve(static_cast<std::size_t>(rowsPerStrip_) * static_cast<std::size_t>(layout_.size.x) *
                       bytesPerFileValue(layout_.type));
}

std::size_t TiffPages::bytesNeeded(const TiffLayout& layout) {
    if (!layout.isPacked)
        return 0;
    const auto rows = static_cast<std::size_t>(rowsPerStripOf(layout));
    const std::size_t strip = rows * static_cast<std::size_t>(layout.size.x) * bytesPerFileValue(layout.type);
    const std::size_t strips = static_cast<std::size_t>(layout.pages) *
                               ((static_cast<std::size_t>(layout.size.y) + rows - 1) / rows);
    return 3 * strip + 2 * 2 * sizeof(std::uint64_t) * strips; // tables grow by doubling
}

std::uint64_t TiffPages::pageBytes() const {
    return static_cast<std::uint64_t>(layout_.size.x) * static_cast<std::uint64_t>(layout_.size.y) *
           bytesPerFileValue(layout_.type);
}

int TiffPages::stripsOfPage() const {
    return (layout_.size.y + rowsPerStrip_ - 1) / rowsPerStrip_;
}

void TiffPages::append(std::span<const std::byte> pixels) {
    if (!layout_.isPacked) {
        file_.append(pixels);
        return;
    }
    const std::size_t whole = static_cast<std::size_t>(rowsPerStrip_) *
                              static_cast<std::size_t>(layout_.size.x) * bytesPerFileValue(layout_.type);
    while (!pixels.empty()) {
        const std::size_t left = static_cast<std::size_t>(pageBytes() - inPage_),
                          now = std::min({pixels.size(), whole - strip_.size(), left});
        strip_.insert(strip_.end(), pixels.begin(), pixels.begin() + static_cast<std::ptrdiff_t>(now));
        pixels = pixels.subspan(now);
        inPage_ += now;
        if (strip_.size() == whole || inPage_ == pageBytes())
            flushStrip();
        if (inPage_ == pageBytes())
            inPage_ = 0;
    }
}

void TiffPages::flushStrip() {
    uLongf size = compressBound(static_cast<uLong>(strip_.size()));
    packed_.resize(size);
    const int result =
        compress(reinterpret_cast<Bytef*>(packed_.data()), &size,
                 reinterpret_cast<const Bytef*>(strip_.data()), static_cast<uLong>(strip_.size()));
    TESSERA_CHECK(result == Z_OK);
    offsets_.push_back(file_.size());
    sizes_.push_back(size);
    file_.append(std::span(packed_).first(size));
    strip_.clear();
}

void TiffPages::writeDirectories() {
    const auto align = [&] { file_.append(std::string_view("\0\0\0\0\0\0\0", (8 - file_.size() % 8) % 8)); };
    align();
    // Shared by all pages: the resolution, in pixels per millimetre, and the tables of strips.
    const Rational x = rationalOf(1 / layout_.pixelMm.x), y = rationalOf(1 / layout_.pixelMm.y);
    const std::uint64_t resolution = file_.size();
    for (const std::uint32_t number : {x.above, x.below, y.above, y.below})
        file_.append(bytesOf(number));
    const std::uint64_t description = file_.size(), descriptionBytes = layout_.description.size() + 1;
    file_.append(std::string_view(layout_.description.c_str(), descriptionBytes));
    align();
    const auto table = [&](const std::vector<std::uint64_t>& numbers) {
        const std::uint64_t at = file_.size();
        for (const std::uint64_t number : numbers)
            file_.append(bytesOf(number).first(isBig_ ? 8 : 4));
        return at;
    };
    const bool hasTables = layout_.isPacked && stripsOfPage() > 1;
    const std::uint64_t offsetTable = hasTables ? table(offsets_) : 0,
                        sizeTable = hasTables ? table(sizes_) : 0;
    align();
    const std::uint64_t first = file_.size();
    file_.replace(isBig_ ? 8 : 4, bytesOf(first).first(isBig_ ? 8 : 4));
    const TiffType offsetType = isBig_ ? kLong8 : kLong;
    constexpr std::uint64_t kEntries = 13;
    const auto strips = static_cast<std::uint64_t>(stripsOfPage());
    for (int page = 0; page < layout_.pages; ++page) {
        const auto number = static_cast<std::uint64_t>(page);
        Directory directory(isBig_);
        directory.number(256, kLong, static_cast<std::uint64_t>(layout_.size.x));
        directory.number(257, kLong, static_cast<std::uint64_t>(layout_.size.y));
        directory.number(258, kShort, 8 * bytesPerFileValue(layout_.type));
        directory.number(259, kShort, layout_.isPacked ? 8 : 1); // deflate or none
        directory.number(262, kShort, 1);                        // 0 is black
        if (page == 0)
            directory.elsewhere(270, kAscii, descriptionBytes, description);
        const std::uint64_t at = number * strips * (isBig_ ? 8 : 4);
        if (hasTables)
            directory.elsewhere(273, offsetType, strips, offsetTable + at);
        else
            directory.number(273, offsetType,
                             layout_.isPacked ? offsets_[number] : pixelsBegin_ + number * pageBytes());
        directory.number(277, kShort, 1);
        directory.number(278, kLong, static_cast<std::uint64_t>(rowsPerStrip_));
        if (hasTables)
            directory.elsewhere(279, offsetType, strips, sizeTable + at);
        else
            directory.number(279, offsetType, layout_.isPacked ? sizes_[number] : pageBytes());
        directory.rational(282, x, resolution);
        directory.rational(283, y, resolution + 8);
        directory.number(296, kShort, 1); // the unit is in the description
        directory.number(339, kShort, sampleFormat(layout_.type));
        const std::uint64_t size = Directory::bytesOf(isBig_, page == 0 ? kEntries + 1 : kEntries);
        const std::uint64_t next = (file_.size() + size + 7) / 8 * 8;
        file_.append(directory.finish(page + 1 < layout_.pages ? next : 0));
        align();
    }
}

void TiffPages::finish() {
    if (!strip_.empty())
        flushStrip();
    writeDirectories();
    file_.finish();
}

} // namespace tessera

// bricking/import/labels/seg/seg_pixels.cpp: see seg_pixels.h.
#include "bricking/import/labels/seg/seg_pixels.h"

#include "bricking/import/codecs/stream.h"
#include "bricking/import/dicom/dicom_deflated.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace tessera {

SegPixels::SegPixels(const SegObject& seg, const std::filesystem::path& scratchFolder)
    : seg_(seg), file_(seg.file),
      pixels_(static_cast<std::uint64_t>(seg.rows) * static_cast<std::uint64_t>(seg.columns)) {
    if (seg.isDeflated) {
        spool_ = std::make_unique<SpoolFile>(scratchFolder);
        spoolInflated(seg.file, *spool_);
    }
    if (seg.coding == SegCoding::plain)
        return;
    fragments_ = framesOf(file_, seg.pixelOffsetBytes, static_cast<int>(seg.frames.size()));
    checkRoom();
}

/// A frame that no compression could make of its bytes is refused before room is made for it. JPEG-LS and
/// JPEG 2000 have no such bound; their frames have one of their own.
void SegPixels::checkRoom() const {
    constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 26;
    const auto each = static_cast<std::uint64_t>(seg_.bitsAllocated);
    const std::uint64_t ratio = seg_.coding == SegCoding::framesPlain ? 1
                                : seg_.coding == SegCoding::rle       ? 64   // two bytes for 128
                                : seg_.coding == SegCoding::jpeg      ? each // a bit for each
                                                                      : 0;
    for (const std::vector<Fragment>& fragments : fragments_) {
        std::uint64_t bytes = 0;
        for (const Fragment& fragment : fragments)
            bytes += fragment.lengthBytes;
        if (ratio > 0 ? (pixels_ * each + 7) / 8 > bytes * ratio : pixels_ > kMostPixels)
            throw badFile(seg_.file.string(),
                          std::to_string(seg_.columns) + " x " + std::to_string(seg_.rows) +
                              " pixels in every frame",
                          "a frame of " + std::to_string(bytes) + " bytes");
    }
}

void SegPixels::readAt(std::uint64_t offset, std::span<std::byte> out) const {
    if (spool_)
        spool_->readAt(offset, out);
    else
        file_.readAt(offset, out);
}

/// Frames of bits follow each other without filling, so one may begin within a byte.
void SegPixels::readBits(std::size_t frame, std::span<std::uint64_t> out) {
    const bool isPlain = seg_.coding == SegCoding::plain;
    const std::uint64_t firstBit = isPlain ? frame * pixels_ : 0;
    const auto shift = static_cast<unsigned>(firstBit % 8);
    const std::size_t count = static_cast<std::size_t>((shift + pixels_ + 7) / 8);
    if (isPlain) {
        bytes_.resize(count);
        readAt(seg_.pixelOffsetBytes + firstBit / 8, bytes_);
    } else {
        bytes_ = readFrame(file_, fragments_[frame]);
    }
    // Eight bytes of the mask from nine of the file.
    bytes_.resize(8 * out.size() + 1);
    for (std::size_t i = 0; i < out.size(); ++i) {
        std::uint64_t word = 0;
        for (std::size_t byte = 0; byte < 8; ++byte)
            word |= std::to_integer<std::uint64_t>(bytes_[8 * i + byte]) << 8 * byte;
        word >>= shift;
        if (shift > 0)
            word |= std::to_integer<std::uint64_t>(bytes_[8 * i + 8]) << (64 - shift);
        out[i] = word;
    }
    if (pixels_ % 64 != 0)
        out.back() &= (std::uint64_t{1} << pixels_ % 64) - 1;
}

void SegPixels::readMask(std::size_t frame, std::span<std::uint64_t> out) {
    TESSERA_CHECK(out.size() == maskWords());
    if (seg_.bitsAllocated == 1)
        return readBits(frame, out);
    values_.resize(pixels_);
    readValues(frame, values_);
    std::fill(out.begin(), out.end(), 0);
    const std::uint32_t least = seg_.kind == SegKind::fractional ? seg_.halfValue : 1;
    for (std::size_t i = 0; i < values_.size(); ++i)
        if (values_[i] >= least)
            out[i / 64] |= std::uint64_t{1} << i % 64;
}

void SegPixels::readValues(std::size_t frame, std::span<std::uint16_t> out) {
    TESSERA_CHECK(out.size() == pixels_ && seg_.bitsAllocated >= 8);
    const auto each = static_cast<std::size_t>(seg_.bitsAllocated / 8);
    const std::string where = seg_.file.string();
    if (seg_.coding == SegCoding::plain) {
        bytes_.resize(out.size() * each);
        readAt(seg_.pixelOffsetBytes + frame * bytes_.size(), bytes_);
    } else {
        bytes_ = readFrame(file_, fragments_[frame]);
    }
    if (seg_.coding == SegCoding::plain || seg_.coding == SegCoding::framesPlain) {
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = each == 1
                         ? std::to_integer<std::uint16_t>(bytes_[i])
                         : static_cast<std::uint16_t>(std::to_integer<unsigned>(bytes_[2 * i]) |
                                                      std::to_integer<unsigned>(bytes_[2 * i + 1]) << 8);
        return;
    }
    StreamHeader header;
    if (seg_.coding != SegCoding::rle) {
        header = seg_.coding == SegCoding::jpeg2000 ? walkJpeg2000(bytes_, where) : walkJpeg(bytes_, where);
        const StreamCoding expected = seg_.coding == SegCoding::jpeg     ? StreamCoding::jpeg
                                      : seg_.coding == SegCoding::jpegLs ? StreamCoding::jpegLs
                                                                         : StreamCoding::jpeg2000;
        if (header.coding != expected || header.columns != seg_.columns || header.rows != seg_.rows ||
            header.components != 1 || header.bits > seg_.bitsAllocated || header.isSigned.value_or(false) ||
            header.lossy)
            throw badFile(where,
                          "streams without loss of " + std::to_string(seg_.columns) + " x " +
                              std::to_string(seg_.rows) + " values of " + std::to_string(seg_.bitsAllocated) +
                              " bits",
                          "another one in frame " + std::to_string(frame + 1));
    }
    decoded_.resize(out.size());
    if (seg_.coding == SegCoding::rle)
        decodeRle(bytes_, static_cast<int>(each), where, decoded_);
    else if (seg_.coding == SegCoding::jpeg)
        decodeJpeg(bytes_, header, where, decoded_);
    else if (seg_.coding == SegCoding::jpegLs)
        decodeJpegLs(bytes_, header, where, decoded_);
    else
        decodeJpeg2000(bytes_, header, where, decoded_);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = static_cast<std::uint16_t>(decoded_[i]);
}

} // namespace tessera

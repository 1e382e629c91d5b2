// bricking/import/dicom/dicom_pixels.cpp: see dicom_pixels.h.
#include "bricking/import/dicom/dicom_pixels.h"

#include "bricking/import/codecs/stream.h"
#include "bricking/import/dicom/dicom_deflated.h"
#include "bricking/import/dicom/encapsulated_frames.h"
#include "bricking/import/source/input_file.h"
#include "bricking/import/source/printable_name.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstring>

namespace tessera {
namespace {

/// The bits that belong to the pixel (others may carry overlays), as a number.
std::int32_t storedValue(std::uint32_t word, const DicomSlice& slice) {
    const std::uint32_t mask = (1u << slice.bitsStored) - 1u;
    const std::uint32_t bits = (word >> (slice.highBit + 1 - slice.bitsStored)) & mask;
    const std::uint32_t sign = 1u << (slice.bitsStored - 1);
    const auto value = static_cast<std::int32_t>(bits);
    return slice.isSigned && (bits & sign) ? value - static_cast<std::int32_t>(mask) - 1 : value;
}

/// True if a word has bits beside the stored ones that are neither an overlay's nor an extended sign.
bool holdsMore(std::uint32_t word, const DicomSlice& slice) {
    const std::uint32_t all = slice.bitsAllocated == 8 ? 0xFFu : 0xFFFFu;
    const std::uint32_t stored = ((1u << slice.bitsStored) - 1u) << (slice.highBit + 1 - slice.bitsStored);
    const std::uint32_t others = word & all & ~stored;
    const std::uint32_t above = all & ~((1u << (slice.highBit + 1)) - 1u);
    const bool isNegative = slice.isSigned && (word >> slice.highBit & 1u) != 0;
    return others != 0 && !(isNegative && others == above);
}

/// word(i) gives the i-th cell of the image as an unsigned number.
template <class Word>
void unpack(const DicomSlice& slice, std::span<std::int32_t> out, StreamFindings& findings, Word word) {
    std::size_t more = 0;
    for (std::size_t i = 0; i < out.size(); ++i) {
        const std::uint32_t bits = word(i);
        more += holdsMore(bits, slice);
        out[i] = storedValue(bits, slice);
    }
    if (more > 0 && !slice.hasOverlayBits && findings.beyond.empty())
        findings.beyond = printableName(slice.file.filename()) + ": " + std::to_string(more) +
                          " pixels have bits beside the " + std::to_string(slice.bitsStored) +
                          " of BitsStored (0028,0101), which are left out; is that tag right?";
}

/// Repairs the lengths of a JPEG 2000 stream's tile-parts. The result can be checked only if the header
/// states the largest value.
std::vector<std::byte> mend(const std::vector<std::byte>& stream, const StreamHeader& header,
                            const DicomSlice& slice) {
    if (!slice.largestStored)
        throw badFile(slice.file.string(),
                      "tile-parts of the stated length, or a largest pixel value for a check", header.damage);
    return withMendedTileParts(stream, slice.file.string());
}

void checkMended(const StreamHeader& header, const DicomSlice& slice, std::span<const std::int32_t> values) {
    const std::int32_t largest = *std::max_element(values.begin(), values.end());
    if (largest != *slice.largestStored)
        throw badFile(slice.file.string(),
                      "a largest pixel value of " + std::to_string(*slice.largestStored) +
                          ", as its tags say",
                      std::to_string(largest) + " after repair (" + header.damage + ")");
}

} // namespace

void DicomPixels::decode(const DicomSlice& slice, std::span<std::int32_t> out) {
    const std::string where = slice.file.string();
    std::vector<std::byte> stream = readFrame(InputFile(slice.file), slice.fragments);
    if (slice.stream == StreamCoding::rle) {
        decodeRle(stream, slice.bitsAllocated / 8, where, out);
        unpack(slice, out, findings_, [&](std::size_t i) { return static_cast<std::uint32_t>(out[i]); });
        return;
    }
    const StreamHeader header =
        slice.stream == StreamCoding::jpeg2000 ? walkJpeg2000(stream, where) : walkJpeg(stream, where);
    if (header.coding != slice.stream)
        throw badFile(where, std::string("a ") + name(slice.stream) + " stream, as its transfer syntax says",
                      name(header.coding));
    checkShape(header, slice);
    if (!header.damage.empty())
        stream = mend(stream, header, slice);
    switch (header.coding) {
    case StreamCoding::jpeg2000:
        decodeJpeg2000(stream, header, where, out);
        break;
    case StreamCoding::jpegLs:
        decodeJpegLs(stream, header, where, out);
        break;
    default:
        decodeJpeg(stream, header, where, out);
    }
    fitToTags(header, slice, out, findings_);
    if (header.damage.empty())
        return;
    checkMended(header, slice, out);
    if (findings_.mended.empty())
        findings_.mended = slice.file.filename().string() + ": " + header.damage;
}

void DicomPixels::read(const DicomSlice& slice, std::span<std::int32_t> out) {
    TESSERA_CHECK(out.size() ==
                  static_cast<std::size_t>(slice.columns) * static_cast<std::size_t>(slice.rows));
    if (slice.coding == PixelCoding::compressed)
        return decode(slice, out);
    const auto valueBytes = static_cast<std::size_t>(slice.bitsAllocated / 8);
    buffer_.resize(out.size() * valueBytes);
    if (slice.coding == PixelCoding::deflated) {
        readInflated(slice.file, slice.pixelOffsetBytes, buffer_);
    } else {
        InputFile(slice.file).readAt(slice.pixelOffsetBytes, buffer_);
    }
    const auto byte = [this](std::size_t i) { return std::to_integer<std::uint32_t>(buffer_[i]); };
    if (valueBytes == 1) {
        unpack(slice, out, findings_, byte);
    } else if (slice.coding == PixelCoding::bigEndian) {
        unpack(slice, out, findings_, [&](std::size_t i) { return byte(2 * i) << 8 | byte(2 * i + 1); });
    } else {
        unpack(slice, out, findings_, [&](std::size_t i) { return byte(2 * i + 1) << 8 | byte(2 * i); });
    }
}

} // namespace tessera

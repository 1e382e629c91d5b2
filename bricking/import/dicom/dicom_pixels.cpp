// bricking/import/dicom/dicom_pixels.cpp: see dicom_pixels.h.
#include "bricking/import/dicom/dicom_pixels.h"

#include "bricking/import/codecs/stream.h"
#include "bricking/import/dicom/dicom_deflated.h"
#include "bricking/import/dicom/encapsulated_frames.h"
#include "bricking/import/source/source_files.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstring>

namespace tessera {
namespace {

struct Range {
    std::int32_t least = 0, most = 0;
    bool holds(const Range& other) const { return other.least >= least && other.most <= most; }
};

Range rangeOf(int bits, bool isSigned) {
    return isSigned ? Range{-(1 << (bits - 1)), (1 << (bits - 1)) - 1} : Range{0, (1 << bits) - 1};
}
Range rangeOf(std::span<const std::int32_t> values) {
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    return {*least, *most};
}

/// The lowest `bits` of a value as a number of that many bits.
std::int32_t reread(std::int32_t value, int bits, bool isSigned) {
    const std::int32_t mask = (1 << bits) - 1, word = value & mask;
    return isSigned && word > mask / 2 ? word - mask - 1 : word;
}
void rereadAll(std::span<std::int32_t> values, int bits, bool isSigned) {
    for (std::int32_t& value : values)
        value = reread(value, bits, isSigned);
}
Range rangeReread(std::span<const std::int32_t> values, int bits, bool isSigned) {
    Range range{INT32_MAX, INT32_MIN};
    for (const std::int32_t value : values) {
        const std::int32_t read = reread(value, bits, isSigned);
        range = {std::min(range.least, read), std::max(range.most, read)};
    }
    return range;
}

std::string sayBits(int bits, bool isSigned) {
    return (isSigned ? "signed " : "unsigned ") + std::to_string(bits) + " bits";
}

void noteDisagreement(const StreamHeader& stream, const DicomSlice& slice, bool streamSigned,
                      const std::string& taken, StreamFindings& findings) {
    if (findings.disagreement.empty())
        findings.disagreement = slice.file.filename().string() + ": the compressed stream says " +
                                sayBits(stream.bits, streamSigned) + ", the tags say " +
                                sayBits(slice.bitsStored, slice.isSigned) + "; " + taken;
}

void clampTo(const Range& range, std::span<std::int32_t> values, StreamFindings& findings) {
    for (std::int32_t& value : values)
        if (value < range.least || value > range.most) {
            value = std::clamp(value, range.least, range.most);
            ++findings.clamped;
        }
}

/// Streams without a sign hold the pixels' words; the tags give the sign.
bool readWords(const StreamHeader& stream, const DicomSlice& slice, std::span<std::int32_t> values) {
    if (!slice.isSigned)
        return false;
    const std::int32_t most = rangeOf(values).most;
    // Words of fewer bits than the tags state: it is unknown whether the missing bits repeat the sign.
    if (stream.bits < slice.bitsStored && most >= 1 << (stream.bits - 1))
        throw badFile(slice.file.string(),
                      "a stream of " + std::to_string(slice.bitsStored) + " bits for signed pixels",
                      std::to_string(stream.bits) + " bits");
    // Writers either mask the words to the stored bits or extend their sign over all bits of the stream.
    const bool masked = most < 1 << std::min(slice.bitsStored, stream.bits);
    rereadAll(values, masked ? std::min(slice.bitsStored, stream.bits) : stream.bits, true);
    return true;
}

} // namespace

void fitToTags(const StreamHeader& stream, const DicomSlice& slice, std::span<std::int32_t> values,
               StreamFindings& findings) {
    findings.lossy = findings.lossy || stream.lossy;
    const bool streamSigned = stream.isSigned ? *stream.isSigned : readWords(stream, slice, values);
    const Range stored = rangeOf(slice.bitsStored, slice.isSigned);
    const Range own = rangeOf(values);
    const bool signsDiffer = streamSigned != slice.isSigned;
    if (signsDiffer || stream.bits < slice.bitsStored)
        noteDisagreement(stream, slice, streamSigned, "read as the stream says", findings);
    if (stored.holds(own))
        return;
    if (signsDiffer && stored.holds(rangeReread(values, stream.bits, slice.isSigned))) {
        // Words that were compressed with the other sign; only then do their values fit the tags.
        rereadAll(values, stream.bits, slice.isSigned);
        return;
    }
    // A lossy stream may overshoot a little. Values far outside are no overshoot: the tags are wrong then.
    const std::int32_t margin = (stored.most - stored.least) / 16 + 1;
    const Range nearby{stored.least - margin, stored.most + margin};
    if (stream.lossy && (!signsDiffer || nearby.holds(own)))
        return clampTo(stored, values, findings);
    noteDisagreement(stream, slice, streamSigned, "read as the stream says", findings);
}

void checkShape(const StreamHeader& stream, const DicomSlice& slice) {
    if (stream.columns != slice.columns || stream.rows != slice.rows || stream.components != 1)
        throw badFile(
            slice.file.string(),
            "a compressed image of " + std::to_string(slice.columns) + " x " + std::to_string(slice.rows) +
                ", as its tags say",
            "a stream of " + std::to_string(stream.columns) + " x " + std::to_string(stream.rows) +
                (stream.components == 1 ? "" : ", " + std::to_string(stream.components) + " components"));
}

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

void StreamFindings::add(const StreamFindings& later) {
    clamped += later.clamped;
    lossy = lossy || later.lossy;
    for (std::string StreamFindings::*const line :
         {&StreamFindings::disagreement, &StreamFindings::beyond, &StreamFindings::mended})
        if ((this->*line).empty())
            this->*line = later.*line;
}

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

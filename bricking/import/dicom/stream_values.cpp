// bricking/import/dicom/stream_values.cpp: see stream_values.h.
#include "bricking/import/dicom/stream_values.h"

#include "core/base/error.h"

#include <algorithm>

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

} // namespace tessera

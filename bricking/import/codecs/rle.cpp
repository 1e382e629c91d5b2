// bricking/import/codecs/rle.cpp: decodeRle of stream.h.
#include "bricking/import/codecs/stream.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>

namespace tessera {
namespace {

constexpr std::size_t kHeaderBytes = 64; // the number of segments, then 15 offsets, little endian

std::size_t littleEndian(Bytes bytes, std::size_t at) {
    std::size_t value = 0;
    for (std::size_t i = 4; i-- > 0;)
        value = value << 8 | std::to_integer<std::size_t>(bytes[at + i]);
    return value;
}

/// One segment: runs and literals of bytes, into every sample's byte at `shift`.
void unpackSegment(Bytes segment, int shift, const std::string& where, std::span<std::int32_t> out) {
    std::size_t done = 0, at = 0;
    const auto refuse = [&](const std::string& found) {
        throw badFile(where, "RLE segments of " + std::to_string(out.size()) + " bytes each", found);
    };
    while (done < out.size()) {
        if (at >= segment.size())
            refuse("one of " + std::to_string(done));
        const int control = std::to_integer<int>(segment[at++]);
        if (control == 128)
            continue; // says nothing
        const bool isRun = control > 128;
        const auto count = static_cast<std::size_t>(isRun ? 257 - control : control + 1);
        const std::size_t bytes = isRun ? 1 : count;
        if (bytes > segment.size() - at || count > out.size() - done)
            refuse(bytes > segment.size() - at ? "one that ends within a run" : "one with more");
        for (std::size_t i = 0; i < count; ++i)
            out[done + i] |= std::to_integer<std::int32_t>(segment[isRun ? at : at + i]) << shift;
        done += count;
        at += bytes;
    }
    // Segments are padded to an even length; some writers pad with zeros to more.
    const Bytes rest = segment.subspan(at);
    if (rest.size() > 1 &&
        std::any_of(rest.begin(), rest.end(), [](std::byte b) { return b != std::byte{0}; }))
        refuse("one with " + std::to_string(rest.size()) + " bytes behind them");
}

} // namespace

void decodeRle(Bytes stream, int bytesPerSample, const std::string& where, std::span<std::int32_t> out) {
    const auto wanted = static_cast<std::size_t>(bytesPerSample);
    if (stream.size() < kHeaderBytes)
        throw badFile(where, "an RLE header of 64 bytes", std::to_string(stream.size()) + " bytes");
    const std::size_t segments = littleEndian(stream, 0);
    if (segments != wanted)
        throw badFile(where, std::to_string(wanted) + " RLE segments", std::to_string(segments));
    std::fill(out.begin(), out.end(), 0);
    for (std::size_t i = 0; i < segments; ++i) {
        const std::size_t begin = littleEndian(stream, 4 + 4 * i);
        const std::size_t end = i + 1 < segments ? littleEndian(stream, 8 + 4 * i) : stream.size();
        if (begin < kHeaderBytes || begin > end || end > stream.size() || (i == 0 && begin != kHeaderBytes))
            throw badFile(
                where, "RLE segments one after the other within " + std::to_string(stream.size()) + " bytes",
                "segment " + std::to_string(i + 1) + " from " + std::to_string(begin) + " to " +
                    std::to_string(end));
        const int shift = 8 * (bytesPerSample - 1 - static_cast<int>(i));
        unpackSegment(stream.subspan(begin, end - begin), shift, where, out);
    }
}

} // namespace tessera

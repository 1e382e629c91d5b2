// bricking/import/codecs/stream.h: compressed images in DICOM files: the stream's header and its samples.
// Every coding takes two steps. First all markers of the stream are checked, without allocation or trust.
// Then a library decodes, with every warning as an error: a decoder that continues after damage gives wrong
// voxels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

using Bytes = std::span<const std::byte>;

enum class StreamCoding : std::uint8_t { rle, jpeg, jpegLs, jpeg2000 };
/// "RLE", "JPEG", "JPEG-LS", "JPEG 2000".
const char* name(StreamCoding coding);

/// The content of a stream's own header.
struct StreamHeader {
    StreamCoding coding = StreamCoding::jpeg;
    int columns = 0, rows = 0, components = 0;
    int bits = 0;                 // of a sample
    std::optional<bool> isSigned; // JPEG 2000 only; the others have no sign
    bool lossy = false;           // lossy
    int frameMarker = 0;          // JPEG: the second byte of the frame header's marker, C0 to CF
    /// A repairable contradiction in the stream (JPEG 2000: lengths of tile-parts); empty: none.
    std::string damage;
};

/// Checks the markers of a whole stream, from the first to the last one; bytes after the last are padding.
/// Throws InputError naming `where` for a stream of another coding, for a marker or a length that does not
/// fit, and for a stream that ends before its end marker. ITU-T T.81 (JPEG), T.87 (JPEG-LS): annexes B and C.
StreamHeader walkJpeg(Bytes stream, const std::string& where);
/// ITU-T T.800 (JPEG 2000), annex A.
StreamHeader walkJpeg2000(Bytes stream, const std::string& where);
/// The header alone, from the beginning of a stream; nullopt if it is incomplete. Only `lossy`, the shape and
/// the sign may be used.
std::optional<StreamHeader> peekHeader(StreamCoding coding, Bytes beginning);

/// The stream with the true length of every tile-part. Packets hold no marker above FF8F (T.800, B.10.1 and
/// A.1), so tile-parts begin and end at their markers.
std::vector<std::byte> withMendedTileParts(Bytes stream, const std::string& where);

/// Decodes the samples, [y][x], as the stream's header says: signed for signed JPEG 2000, else not negative.
/// header is that of the marker check; out.size() == columns * rows. Throws InputError naming `where` for
/// every complaint of the decoder.
void decodeJpeg(Bytes stream, const StreamHeader& header, const std::string& where,
                std::span<std::int32_t> out);
void decodeJpegLs(Bytes stream, const StreamHeader& header, const std::string& where,
                  std::span<std::int32_t> out);
void decodeJpeg2000(Bytes stream, const StreamHeader& header, const std::string& where,
                    std::span<std::int32_t> out);
/// DICOM PS3.5, annex G. The stream has no header of its own: out.size() samples of bytesPerSample, one
/// segment for each byte, the most significant first.
void decodeRle(Bytes stream, int bytesPerSample, const std::string& where, std::span<std::int32_t> out);

} // namespace tessera

// bricking/import/codecs/jpeg2000_markers.cpp: walkJpeg2000 and withMendedTileParts of stream.h.
#include "bricking/import/codecs/markers.h"
#include "bricking/import/codecs/stream.h"

#include <algorithm>

namespace tessera {
namespace {

constexpr int kCodestream = 0xFF4F, kSize = 0xFF51, kCoding = 0xFF52, kComponentCoding = 0xFF53,
              kTilePart = 0xFF90, kData = 0xFF93, kCodestreamEnd = 0xFFD9;
constexpr std::uint32_t kMostTiles = 65535; // Isot has 16 bits

struct TilePart {
    std::size_t at = 0;     // of its SOT marker
    std::uint32_t said = 0; // Psot: from that marker to the end of its data; 0: to the end of the stream
    std::size_t length = 0; // by the stream itself
};

/// Xsiz to XTOsiz and the components (T.800, A.5.1).
void readSize(const MarkerReader& reader, std::size_t at, std::size_t length, Jpeg2000Header& out) {
    if (length < 41)
        reader.refuse("a size segment of at least 41 bytes", std::to_string(length));
    const std::uint32_t x = reader.u32(at + 4), y = reader.u32(at + 8), x0 = reader.u32(at + 12),
                        y0 = reader.u32(at + 16), tileX = reader.u32(at + 20), tileY = reader.u32(at + 24),
                        tileX0 = reader.u32(at + 28), tileY0 = reader.u32(at + 32);
    out.header.components = reader.u16(at + 36);
    if (x <= x0 || y <= y0 || x - x0 > 65535 || y - y0 > 65535)
        reader.refuse("an image of 1 to 65535 pixels an axis", std::to_string(x) + " x " + std::to_string(y));
    if (tileX == 0 || tileY == 0 || tileX0 > x0 || tileY0 > y0 || tileX > UINT32_MAX - tileX0 ||
        tileY > UINT32_MAX - tileY0 || tileX0 + tileX <= x0 || tileY0 + tileY <= y0)
        reader.refuse("tiles that hold the image's first pixel",
                      std::to_string(tileX) + " x " + std::to_string(tileY));
    if (out.header.components == 0 || length != 38 + 3 * static_cast<std::size_t>(out.header.components))
        reader.refuse("a size segment of its components' length",
                      std::to_string(length) + " bytes for " + std::to_string(out.header.components));
    const std::uint64_t tiles =
        (std::uint64_t{x - tileX0} + tileX - 1) / tileX * ((std::uint64_t{y - tileY0} + tileY - 1) / tileY);
    if (tiles > kMostTiles)
        reader.refuse("at most 65535 tiles", std::to_string(tiles));
    out.tiles = static_cast<std::uint32_t>(tiles);
    out.header.columns = static_cast<int>(x - x0);
    out.header.rows = static_cast<int>(y - y0);
    const int depth = reader.u8(at + 38);
    out.header.bits = (depth & 127) + 1;
    out.header.isSigned = (depth & 128) != 0;
    if (out.header.bits > 16)
        reader.refuse("samples of at most 16 bits", std::to_string(out.header.bits));
    if (reader.u8(at + 39) != 1 || reader.u8(at + 40) != 1)
        reader.refuse("samples at every pixel", "subsampling");
}

/// The wavelet of a coding segment: 0 is the irreversible one (T.800, table A.20).
bool isIrreversible(const MarkerReader& reader, std::size_t at, std::size_t length, bool ofComponent) {
    const std::size_t wavelet = ofComponent ? 8 : 11; // from the segment's length on; up to 256 components
    return length > wavelet && reader.u8(at + wavelet) == 0;
}

/// The starts of tile-parts, by their markers, and the end of the stream.
std::vector<TilePart> findTileParts(const MarkerReader& reader, const Jpeg2000Header& main) {
    std::vector<TilePart> parts;
    std::size_t at = main.end;
    while (reader.u16(at) == kTilePart) {
        if (reader.u16(at + 2) != 10)
            reader.refuse("a tile-part header of 10 bytes", std::to_string(reader.u16(at + 2)));
        if (static_cast<std::uint32_t>(reader.u16(at + 4)) >= main.tiles)
            reader.refuse("tiles 0 to " + std::to_string(main.tiles - 1), std::to_string(reader.u16(at + 4)));
        TilePart part{at, reader.u32(at + 6), 0};
        for (at += 12; reader.u16(at) != kData;) { // the tile-part's own segments
            if (reader.u16(at) < 0xFF30)
                reader.refuse("a marker at byte " + std::to_string(at), hexByte(reader.u8(at)));
            const int length = reader.u16(at + 2);
            if (length < 2)
                reader.refuse("a segment of at least 2 bytes", std::to_string(length));
            at += 2 + static_cast<std::size_t>(length);
        }
        // FF91 and FF92 lie between and within packets and end nothing.
        for (at += 2; reader.u16(at) <= 0xFF8F || reader.u16(at) == 0xFF91 || reader.u16(at) == 0xFF92;)
            ++at;
        part.length = at - part.at;
        parts.push_back(part);
    }
    if (reader.u16(at) != kCodestreamEnd)
        reader.refuse("a tile-part or the end marker at byte " + std::to_string(at),
                      hexByte(reader.u8(at)) + hexByte(reader.u8(at + 1)));
    if (parts.empty())
        reader.refuse("a tile-part", "none");
    return parts;
}

} // namespace

Jpeg2000Header readJpeg2000Header(const MarkerReader& reader) {
    Jpeg2000Header out;
    out.header.coding = StreamCoding::jpeg2000;
    if (reader.u16(0) != kCodestream)
        reader.refuse("a codestream that begins with FF4F",
                      reader.u16(0) == 0xFFD8 ? "JPEG or JPEG-LS" : "another beginning");
    if (reader.u16(2) != kSize)
        reader.refuse("a size segment first", "another");
    std::size_t at = 2;
    bool coded = false;
    while (reader.u16(at) != kTilePart) {
        const int marker = reader.u16(at);
        const auto length = static_cast<std::size_t>(reader.u16(at + 2));
        if (marker < 0xFF30 || marker == kCodestreamEnd || length < 2)
            reader.refuse("a marker segment at byte " + std::to_string(at), hexByte(marker & 255));
        if (marker == kSize)
            readSize(reader, at + 2, length, out);
        if (marker == kCoding || marker == kComponentCoding)
            out.header.lossy =
                isIrreversible(reader, at + 2, length, marker == kComponentCoding) || out.header.lossy;
        coded = coded || marker == kCoding;
        at += 2 + length;
    }
    if (!coded)
        reader.refuse("a coding segment", "none");
    out.end = at;
    return out;
}

StreamHeader walkJpeg2000(Bytes stream, const std::string& where) {
    const MarkerReader reader(stream, where);
    Jpeg2000Header main = readJpeg2000Header(reader);
    const std::vector<TilePart> parts = findTileParts(reader, main);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const TilePart& part = parts[i];
        const bool untilEnd = part.said == 0 && i + 1 == parts.size();
        if (!untilEnd && part.said > part.length)
            main.header.lossy = true; // data was removed: quality layers, if the rest is valid
        if (!untilEnd && part.said != part.length && main.header.damage.empty())
            main.header.damage = "tile-part " + std::to_string(i) + " says " + std::to_string(part.said) +
                                 " bytes and has " + std::to_string(part.length);
    }
    return main.header;
}

std::vector<std::byte> withMendedTileParts(Bytes stream, const std::string& where) {
    const MarkerReader reader(stream, where);
    std::vector<std::byte> mended(stream.begin(), stream.end());
    for (const TilePart& part : findTileParts(reader, readJpeg2000Header(reader)))
        for (std::size_t i = 0; i < 4; ++i)
            mended[part.at + 6 + i] = static_cast<std::byte>(part.length >> (24 - 8 * i) & 255);
    return mended;
}

} // namespace tessera

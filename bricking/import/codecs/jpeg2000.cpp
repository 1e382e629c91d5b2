// bricking/import/codecs/jpeg2000.cpp: JPEG 2000 of stream.h: its markers, tile parts that need mending, and
// decoding by OpenJPEG in its strict mode.
#include "bricking/import/codecs/markers.h"
#include "bricking/import/codecs/stream.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <openjpeg.h>

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

namespace {

/// The stream as the library reads it.
struct Cursor {
    Bytes bytes;
    std::size_t at = 0;
};
constexpr auto kNoMore = static_cast<OPJ_SIZE_T>(-1);

OPJ_SIZE_T readSome(void* to, OPJ_SIZE_T count, void* user) {
    auto& cursor = *static_cast<Cursor*>(user);
    const std::size_t got = std::min(count, cursor.bytes.size() - cursor.at);
    if (got == 0)
        return kNoMore;
    std::memcpy(to, cursor.bytes.data() + cursor.at, got);
    cursor.at += got;
    return got;
}
OPJ_OFF_T skipSome(OPJ_OFF_T count, void* user) {
    auto& cursor = *static_cast<Cursor*>(user);
    const auto left = static_cast<OPJ_OFF_T>(cursor.bytes.size() - cursor.at);
    if (count < 0 || count > left)
        return -1;
    cursor.at += static_cast<std::size_t>(count);
    return count;
}
OPJ_BOOL seekTo(OPJ_OFF_T place, void* user) {
    auto& cursor = *static_cast<Cursor*>(user);
    if (place < 0 || static_cast<std::size_t>(place) > cursor.bytes.size())
        return OPJ_FALSE;
    cursor.at = static_cast<std::size_t>(place);
    return OPJ_TRUE;
}

/// Other output of the library, which is not printed.
void complain(const char*, void* user) {
    *static_cast<bool*>(user) = true;
}
void sayNothing(const char*, void*) {}

// The library's codec and stream are the same type to C++, so each has a deleter of its own.
struct DestroyCodec {
    void operator()(opj_codec_t* codec) const { opj_destroy_codec(codec); }
};
struct DestroyStream {
    void operator()(opj_stream_t* stream) const { opj_stream_destroy(stream); }
};
struct DestroyImage {
    void operator()(opj_image_t* image) const { opj_image_destroy(image); }
};

} // namespace

void decodeJpeg2000(Bytes bytes, const StreamHeader& header, const std::string& where,
                    std::span<std::int32_t> out) {
    Cursor cursor{bytes};
    bool complained = false;
    const std::unique_ptr<opj_codec_t, DestroyCodec> codec(opj_create_decompress(OPJ_CODEC_J2K));
    const std::unique_ptr<opj_stream_t, DestroyStream> stream(opj_stream_default_create(OPJ_TRUE));
    if (!codec || !stream)
        throw Error("no memory for a JPEG 2000 decoder");
    opj_set_info_handler(codec.get(), sayNothing, nullptr);
    opj_set_warning_handler(codec.get(), complain, &complained);
    opj_set_error_handler(codec.get(), complain, &complained);
    opj_stream_set_read_function(stream.get(), readSome);
    opj_stream_set_skip_function(stream.get(), skipSome);
    opj_stream_set_seek_function(stream.get(), seekTo);
    opj_stream_set_user_data(stream.get(), &cursor, nullptr);
    opj_stream_set_user_data_length(stream.get(), bytes.size());

    opj_dparameters_t parameters;
    opj_set_default_decoder_parameters(&parameters);
    opj_image_t* read = nullptr;
    bool good = opj_setup_decoder(codec.get(), &parameters) &&
                opj_decoder_set_strict_mode(codec.get(), OPJ_TRUE) &&
                opj_read_header(stream.get(), codec.get(), &read);
    const std::unique_ptr<opj_image_t, DestroyImage> image(read);
    good = good && opj_decode(codec.get(), stream.get(), image.get()) &&
           opj_end_decompress(codec.get(), stream.get());
    if (!good || complained || image->numcomps != 1 || !image->comps[0].data)
        throw badFile(where, "compressed pixels that decode without a fault", "damaged JPEG 2000 data");
    const opj_image_comp_t& samples = image->comps[0];
    if (static_cast<int>(samples.w) != header.columns || static_cast<int>(samples.h) != header.rows ||
        static_cast<int>(samples.prec) != header.bits || (samples.sgnd != 0) != header.isSigned)
        throw badFile(where, "one JPEG 2000 header", "two that differ");
    std::copy_n(samples.data, out.size(), out.begin());
}

} // namespace tessera

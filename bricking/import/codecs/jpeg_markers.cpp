// bricking/import/codecs/jpeg_markers.cpp: walkJpeg of stream.h, for JPEG and JPEG-LS, which share their
// markers.
#include "bricking/import/codecs/markers.h"
#include "bricking/import/codecs/stream.h"
#include "core/base/error.h"

namespace tessera {
namespace {

constexpr int kStart = 0xD8, kEnd = 0xD9, kScan = 0xDA, kLines = 0xDC, kFrameLs = 0xF7;

bool isFrame(int code) {
    // C4, C8 and CC are tables; C5 to C7 and C9 to CF are hierarchical or arithmetic codings.
    return (code >= 0xC0 && code <= 0xCF && code != 0xC4 && code != 0xC8 && code != 0xCC) || code == kFrameLs;
}
bool isDecoded(int code) {
    return (code >= 0xC0 && code <= 0xC3) || code == kFrameLs;
}
bool isRestart(int code) {
    return code >= 0xD0 && code <= 0xD7;
}

/// P, Y, X, Nf of a frame header (T.81, B.2.2), from its length on.
void readFrameHeader(MarkerReader& reader, int code, std::size_t at, std::size_t length,
                     StreamHeader& header) {
    if (header.frameMarker != 0)
        reader.refuse("one frame header", "a second one");
    if (!isDecoded(code))
        reader.refuse("a sequential, progressive or lossless Huffman coded JPEG, or JPEG-LS",
                      "frame marker FF" + hexByte(code));
    if (length < 8)
        reader.refuse("a frame header of at least 8 bytes", std::to_string(length));
    header.frameMarker = code;
    header.coding = code == kFrameLs ? StreamCoding::jpegLs : StreamCoding::jpeg;
    header.bits = reader.u8(at + 2);
    header.rows = reader.u16(at + 3);
    header.columns = reader.u16(at + 5);
    header.components = reader.u8(at + 7);
    header.lossy = code <= 0xC2; // C3 and F7: the scan header decides
    const int least = code == 0xC3 || code == kFrameLs ? 2 : 8;
    const int most = code == 0xC0 ? 8 : code == 0xC1 || code == 0xC2 ? 12 : 16;
    if (header.bits < least || header.bits > most)
        reader.refuse("samples of " + std::to_string(least) + " to " + std::to_string(most) + " bits",
                      std::to_string(header.bits));
    if (header.rows == 0 || header.columns == 0)
        reader.refuse("an image of at least one pixel",
                      std::to_string(header.columns) + " x " + std::to_string(header.rows));
    if (header.components == 0 || length != 8 + 3 * static_cast<std::size_t>(header.components))
        reader.refuse("a frame header of its components' length", std::to_string(length) + " bytes for " +
                                                                      std::to_string(header.components) +
                                                                      " components");
}

/// The end of a scan header tells the loss: NEAR of JPEG-LS, the point transform of lossless JPEG.
void readScan(MarkerReader& reader, std::size_t at, std::size_t length, StreamHeader& header) {
    if (header.frameMarker == 0)
        reader.refuse("a frame header before the first scan", "none");
    const std::size_t components = length >= 3 ? static_cast<std::size_t>(reader.u8(at + 2)) : 0;
    if (components == 0 || length != 6 + 2 * components)
        reader.refuse("a scan header of its components' length", std::to_string(length) + " bytes");
    const int near = reader.u8(at + length - 3), pointTransform = reader.u8(at + length - 1) & 15;
    if (header.frameMarker == kFrameLs)
        header.lossy = header.lossy || near > 0 || pointTransform > 0;
    else if (header.frameMarker == 0xC3)
        header.lossy = header.lossy || pointTransform > 0;
}

/// From the first byte of entropy-coded data to the marker that ends it; restart markers must count.
std::size_t endOfScan(MarkerReader& reader, std::size_t at, bool isLs) {
    int expectedRestart = 0;
    while (true) {
        while (reader.u8(at) != 0xFF)
            ++at;
        const int code = reader.u8(at + 1);
        if (isLs ? code < 0x80 : code == 0) { // a stuffed bit or byte
            at += 2;
        } else if (code == 0xFF) { // fill
            ++at;
        } else if (isRestart(code)) {
            if (code - 0xD0 != expectedRestart)
                reader.refuse("restart marker " + std::to_string(expectedRestart) + " at byte " +
                                  std::to_string(at),
                              std::to_string(code - 0xD0));
            expectedRestart = (expectedRestart + 1) % 8;
            at += 2;
        } else {
            return at;
        }
    }
}

StreamHeader walk(MarkerReader& reader, bool onlyHeader) {
    StreamHeader header;
    if (reader.u16(0) != (0xFF00 | kStart))
        reader.refuse("a stream that begins with FFD8", "FF" == hexByte(reader.u8(0)) && reader.u8(1) == 0x4F
                                                            ? "JPEG 2000"
                                                            : "another beginning");
    bool scanned = false;
    for (std::size_t at = 2;;) {
        if (reader.u8(at) != 0xFF)
            reader.refuse("a marker at byte " + std::to_string(at), hexByte(reader.u8(at)));
        while (reader.u8(at + 1) == 0xFF)
            ++at; // fill
        const int code = reader.u8(at + 1);
        if (code == kEnd) {
            if (!scanned)
                reader.refuse("a scan before the end of the image", "none");
            return header;
        }
        if (code == 0 || code == 1 || code == kStart || isRestart(code))
            reader.refuse("a marker segment at byte " + std::to_string(at), "FF" + hexByte(code));
        const auto length = static_cast<std::size_t>(reader.u16(at + 2));
        if (length < 2 || !reader.has(at + 2, length))
            reader.refuse("a segment that ends within the stream",
                          "a length of " + std::to_string(length) + " at byte " + std::to_string(at + 2));
        if (code == kLines)
            reader.refuse("the number of lines in the frame header", "a marker that redefines it");
        if (isFrame(code))
            readFrameHeader(reader, code, at + 2, length, header);
        if (code == kScan) {
            readScan(reader, at + 2, length, header);
            if (onlyHeader)
                return header;
            scanned = true;
            at = endOfScan(reader, at + 2 + length, header.coding == StreamCoding::jpegLs);
        } else {
            at += 2 + length;
        }
    }
}

} // namespace

const char* name(StreamCoding coding) {
    switch (coding) {
    case StreamCoding::rle:
        return "RLE";
    case StreamCoding::jpeg:
        return "JPEG";
    case StreamCoding::jpegLs:
        return "JPEG-LS";
    case StreamCoding::jpeg2000:
        return "JPEG 2000";
    }
    return "?";
}

StreamHeader walkJpeg(Bytes stream, const std::string& where) {
    MarkerReader reader(stream, where);
    return walk(reader, false);
}

std::optional<StreamHeader> peekHeader(StreamCoding coding, Bytes beginning) {
    try {
        MarkerReader reader(beginning, "");
        if (coding == StreamCoding::jpeg2000)
            return readJpeg2000Header(reader).header;
        if (coding != StreamCoding::rle)
            return walk(reader, true);
    } catch (const InputError&) { // missing, or damaged: the decoder reports it
    }
    return std::nullopt;
}

} // namespace tessera

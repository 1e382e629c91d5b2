// bricking/import/codecs/markers.h: reads big-endian numbers of a stream by position, for the marker checks
// of stream.h. Reading beyond the end is an error that names the file.
#pragma once

#include "bricking/import/codecs/stream.h"
#include "core/base/error.h"

#include <string>
#include <utility>

namespace tessera {

inline std::string hexByte(int value) {
    constexpr const char* kDigits = "0123456789ABCDEF";
    return {kDigits[value >> 4 & 15], kDigits[value & 15]};
}

class MarkerReader {
  public:
    MarkerReader(Bytes bytes, std::string where) : bytes_(bytes), where_(std::move(where)) {}

    std::size_t size() const { return bytes_.size(); }
    bool has(std::size_t at, std::size_t count) const {
        return at <= bytes_.size() && count <= bytes_.size() - at;
    }
    int u8(std::size_t at) const {
        if (!has(at, 1))
            refuse("an end marker", "the end of the stream after " + std::to_string(bytes_.size()) +
                                        " bytes (is it truncated?)");
        return std::to_integer<int>(bytes_[at]);
    }
    int u16(std::size_t at) const { return u8(at) << 8 | u8(at + 1); }
    std::uint32_t u32(std::size_t at) const {
        return static_cast<std::uint32_t>(u16(at)) << 16 | static_cast<std::uint32_t>(u16(at + 2));
    }
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const {
        throw badFile(where_, "compressed pixels with " + expected, found);
    }

  private:
    Bytes bytes_;
    std::string where_;
};

/// The main header of a JPEG 2000 codestream, and where its first tile-part begins.
struct Jpeg2000Header {
    StreamHeader header;
    std::size_t end = 0;
    std::uint32_t tiles = 0;
};
Jpeg2000Header readJpeg2000Header(const MarkerReader& reader);

} // namespace tessera

// bricking/import/dicom/dicom_deflated.cpp: see dicom_deflated.h. The file begins with 128 bytes, "DICM" and
// the meta group (0002,xxxx), which is never compressed; all that follows is one raw deflate stream (DICOM
// PS3.5, A.5).
#include "bricking/import/dicom/dicom_deflated.h"

#include "bricking/import/source/input_file.h"
#include "core/error.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <zlib.h>

namespace tessera {
namespace {

constexpr std::size_t kLargestInflated = std::size_t{512} << 20;
constexpr std::size_t kMetaBegin = 132; // preamble and "DICM"

std::uint32_t littleEndian(const std::byte* at, int bytes) {
    std::uint32_t value = 0;
    for (int i = bytes - 1; i >= 0; --i)
        value = value << 8 | std::to_integer<std::uint32_t>(at[i]);
    return value;
}

/// Where the meta group ends: the first element that is not of group 2.
std::size_t endOfMeta(const std::vector<std::byte>& bytes, const std::string& where) {
    std::size_t at = kMetaBegin;
    while (at + 12 <= bytes.size() && littleEndian(&bytes[at], 2) == 2) {
        const bool longForm =
            std::memcmp(&bytes[at + 4], "OB", 2) == 0 || std::memcmp(&bytes[at + 4], "UN", 2) == 0;
        const std::size_t length =
            longForm ? littleEndian(&bytes[at + 8], 4) : littleEndian(&bytes[at + 6], 2);
        at += (longForm ? 12 : 8) + length;
    }
    const bool said = bytes.size() >= kMetaBegin + 12 && littleEndian(&bytes[kMetaBegin], 4) == 0x00000002;
    if (!said || kMetaBegin + 12 + littleEndian(&bytes[kMetaBegin + 8], 4) != at)
        throw badFile(where, "a meta group of the length that it says", "another");
    if (at >= bytes.size())
        throw badFile(where, "a deflated data set", "the end of the file (is it truncated?)");
    return at;
}

/// Preamble, mark and a meta group that says: explicit little endian.
std::vector<std::byte> plainMeta() {
    std::string text(128, '\0');
    text += "DICM";
    text.append("\x02\x00\x00\x00UL\x04\x00\x1c\x00\x00\x00", 12); // (0002,0000): 28 bytes of group 2 follow
    text.append("\x02\x00\x10\x00UI\x14\x00", 8);                  // (0002,0010), 20 bytes
    text.append("1.2.840.10008.1.2.1", 20);                        // with the zero that makes it even
    std::vector<std::byte> bytes(text.size());
    std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

} // namespace

std::vector<std::byte> inflateDicom(const std::filesystem::path& path) {
    const std::string where = path.string();
    const InputFile file(path);
    if (file.sizeBytes() > kLargestInflated)
        throw badFile(where, "at most 512 MiB", "a larger deflated file");
    std::vector<std::byte> packed(file.sizeBytes());
    file.readAt(0, packed);
    const std::size_t begin = endOfMeta(packed, where);

    std::vector<std::byte> out = plainMeta();
    z_stream stream{};
    if (inflateInit2(&stream, -15) != Z_OK)
        throw Error("zlib cannot start"); // no wrapper
    stream.next_in = reinterpret_cast<Bytef*>(packed.data() + begin);
    stream.avail_in = static_cast<uInt>(packed.size() - begin);
    int result = Z_OK;
    std::vector<std::byte> part(256 * 1024);
    while (result == Z_OK && out.size() < kLargestInflated) {
        stream.next_out = reinterpret_cast<Bytef*>(part.data());
        stream.avail_out = static_cast<uInt>(part.size());
        result = inflate(&stream, Z_NO_FLUSH);
        out.insert(out.end(), part.begin(), part.end() - static_cast<std::ptrdiff_t>(stream.avail_out));
    }
    inflateEnd(&stream);
    // At most a byte that makes the length even. GDCM leaves gzip's trailer too: checksum and size of what
    // was deflated.
    const std::span<const std::byte> rest(reinterpret_cast<const std::byte*>(stream.next_in),
                                          stream.avail_in);
    const std::size_t metaBytes = plainMeta().size();
    const bool isTrailer =
        (rest.size() == 8 || rest.size() == 9) &&
        littleEndian(rest.data(), 4) ==
            static_cast<std::uint32_t>(::crc32(0, reinterpret_cast<const Bytef*>(out.data() + metaBytes),
                                               static_cast<uInt>(out.size() - metaBytes))) &&
        littleEndian(rest.data() + 4, 4) == static_cast<std::uint32_t>(out.size() - metaBytes);
    if (result == Z_STREAM_END && !isTrailer &&
        (rest.size() > 1 || (rest.size() == 1 && rest[0] != std::byte{0})))
        throw badFile(where, "nothing behind the deflated data set",
                      std::to_string(stream.avail_in) + " bytes");
    if (result != Z_STREAM_END)
        throw badFile(where, "a whole deflated data set of at most 512 MiB",
                      "a damaged, truncated or larger one");
    return out;
}

} // namespace tessera

// bricking/import/dicom/dicom_deflated.cpp: see dicom_deflated.h. The file begins with 128 bytes, "DICM" and
// the meta group (0002,xxxx), which is never compressed; all that follows is one raw deflate stream (DICOM
// PS3.5, A.5).
#include "bricking/import/dicom/dicom_deflated.h"

#include "core/base/error.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <sys/mman.h> // memfd_create
#include <unistd.h>
#include <vector>
#include <zlib.h>

namespace tessera {
namespace {

constexpr std::uint64_t kLargestInflated = std::uint64_t{512} << 20;
constexpr std::uint64_t kTailBytes = std::uint64_t{1} << 20; // data after the pixels
constexpr std::size_t kInflatedPart = 256 * 1024;
constexpr std::size_t kMostMeta = 1 << 20; // the meta group has a few short elements
constexpr std::size_t kMetaBegin = 132;    // preamble and "DICM"

std::uint32_t littleEndian(const std::byte* at, int bytes) {
    std::uint32_t value = 0;
    for (int i = bytes - 1; i >= 0; --i)
        value = value << 8 | std::to_integer<std::uint32_t>(at[i]);
    return value;
}

/// The end of the meta group: the first element that is not of group 2.
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

using Sink = std::function<bool(std::uint64_t offset, std::span<const std::byte>)>;

/// Passes on the plain file in portions, from its beginning, until `take` returns false. At its end, what
/// follows is checked. Throws InputError naming the file.
void inflateTo(const std::filesystem::path& path, const Sink& take) {
    const std::string where = path.string();
    const InputFile file(path);
    if (file.sizeBytes() > kLargestInflated)
        throw badFile(where, "at most 512 MiB", "a larger deflated file");
    std::vector<std::byte> packed(std::min<std::uint64_t>(file.sizeBytes(), kMostMeta));
    file.readAt(0, packed);
    std::uint64_t readTo = endOfMeta(packed, where);

    z_stream stream{};
    if (inflateInit2(&stream, -15) != Z_OK) // no wrapper
        throw Error("zlib cannot start");
    const std::unique_ptr<z_stream, int (*)(z_stream*)> ending(&stream, inflateEnd);
    packed.resize(kInflatedPart);
    const auto refill = [&] { // unprocessed bytes stay in front
        std::copy_n(stream.next_in, stream.avail_in, reinterpret_cast<Bytef*>(packed.data()));
        const std::size_t got = file.readSome(readTo, std::span(packed).subspan(stream.avail_in));
        readTo += got;
        stream.next_in = reinterpret_cast<Bytef*>(packed.data());
        stream.avail_in += static_cast<uInt>(got);
    };
    const std::vector<std::byte> meta = plainMeta();
    if (!take(0, meta))
        return;
    std::vector<std::byte> part(kInflatedPart);
    std::uint64_t inflated = 0;
    uLong sum = ::crc32(0, nullptr, 0);
    int result = Z_OK;
    while (result == Z_OK && meta.size() + inflated < kLargestInflated) {
        if (stream.avail_in == 0)
            refill();
        stream.next_out = reinterpret_cast<Bytef*>(part.data());
        stream.avail_out = static_cast<uInt>(part.size());
        result = inflate(&stream, Z_NO_FLUSH);
        const std::span<const std::byte> got = std::span(part).first(part.size() - stream.avail_out);
        sum = ::crc32(sum, reinterpret_cast<const Bytef*>(got.data()), static_cast<uInt>(got.size()));
        if (!got.empty() && !take(meta.size() + inflated, got))
            return;
        inflated += got.size();
    }
    if (result != Z_STREAM_END)
        throw badFile(where, "a whole deflated data set of at most 512 MiB",
                      "a damaged, truncated or larger one");
    // At most a byte that makes the length even. GDCM leaves gzip's trailer too: checksum and size of what
    // was deflated.
    refill();
    const std::span<const std::byte> rest = std::span(packed).first(stream.avail_in);
    const bool isTrailer = (rest.size() == 8 || rest.size() == 9) &&
                           littleEndian(rest.data(), 4) == static_cast<std::uint32_t>(sum) &&
                           littleEndian(rest.data() + 4, 4) == static_cast<std::uint32_t>(inflated);
    if (!isTrailer && (rest.size() > 1 || (rest.size() == 1 && rest[0] != std::byte{0})))
        throw badFile(where, "nothing behind the deflated data set",
                      std::to_string(file.sizeBytes() - readTo + rest.size()) + " bytes");
}

} // namespace

InflatedFile::InflatedFile(const std::filesystem::path& path)
    : descriptor_(::memfd_create("tessera", MFD_CLOEXEC)) {
    const auto put = [this](std::uint64_t offset, std::span<const std::byte> bytes) {
        if (::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset)) !=
            static_cast<ssize_t>(bytes.size()))
            throw Error("no memory file for a deflated DICOM file");
    };
    try {
        std::vector<std::byte> tail; // the last bytes so far
        inflateTo(path, [&](std::uint64_t offset, std::span<const std::byte> bytes) {
            sizeBytes_ = offset + bytes.size();
            if (offset < kMostInflatedHeader)
                put(offset, bytes);
            tail.insert(tail.end(), bytes.begin(), bytes.end());
            if (tail.size() > 2 * kTailBytes)
                tail.erase(tail.begin(), tail.end() - static_cast<std::ptrdiff_t>(kTailBytes));
            return true;
        });
        put(sizeBytes_ - tail.size(), tail);
    } catch (...) {
        ::close(descriptor_);
        throw;
    }
}

InflatedFile::~InflatedFile() {
    ::close(descriptor_);
}

void readInflated(const std::filesystem::path& path, std::uint64_t offset, std::span<std::byte> out) {
    std::uint64_t filled = 0;
    inflateTo(path, [&](std::uint64_t at, std::span<const std::byte> bytes) {
        const std::uint64_t begin = std::max(at, offset + filled), end = at + bytes.size();
        if (begin < end) {
            const auto count = std::min<std::uint64_t>(end - begin, out.size() - filled);
            std::memcpy(out.data() + filled, bytes.data() + (begin - at), count);
            filled += count;
        }
        return filled < out.size();
    });
    if (filled < out.size())
        throw badFile(path.string(), "the pixels that it had when it was opened", "fewer");
}

void spoolInflated(const std::filesystem::path& path, SpoolFile& spool) {
    inflateTo(path, [&](std::uint64_t, std::span<const std::byte> bytes) {
        spool.append(bytes);
        return true;
    });
}

} // namespace tessera

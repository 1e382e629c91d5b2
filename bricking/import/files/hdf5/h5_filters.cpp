// bricking/import/files/hdf5/h5_filters.cpp: readH5Chunk() of h5_chunks.h.
#include "bricking/import/files/hdf5/h5_chunks.h"

#include "core/base/error.h"

#include <algorithm>
#include <string>
#include <utility>
#include <zlib.h>

namespace tessera {
namespace {

constexpr std::size_t kFletcherBytes = 4;

/// Of 16-bit words, the high byte first; an odd byte is the high one of a word.
std::uint32_t fletcher32(std::span<const std::byte> bytes) {
    std::uint32_t low = 0, high = 0;
    constexpr std::size_t kPortion = 360; // words, whose sums do not overflow
    const std::size_t words = bytes.size() / 2;
    const auto fold = [](std::uint32_t sum) { return (sum & 0xffff) + (sum >> 16); };
    const auto at = [&](std::size_t n) { return std::to_integer<std::uint32_t>(bytes[n]); };
    for (std::size_t n = 0; n < words;) {
        for (const std::size_t end = std::min(words, n + kPortion); n < end; ++n)
            high += low += at(2 * n) << 8 | at(2 * n + 1);
        low = fold(low), high = fold(high);
    }
    if (bytes.size() % 2 == 1) {
        high += low += at(bytes.size() - 1) << 8;
        low = fold(low), high = fold(high);
    }
    low = fold(low), high = fold(high);
    return high << 16 | low;
}

void checkSum(std::vector<std::byte>& bytes, const std::string& where) {
    if (bytes.size() < kFletcherBytes)
        throw badFile(where, "a chunk with a checksum (fletcher32)", std::to_string(bytes.size()) + " bytes");
    std::uint32_t said = 0;
    for (std::size_t n = 0; n < kFletcherBytes; ++n)
        said |= std::to_integer<std::uint32_t>(bytes[bytes.size() - kFletcherBytes + n]) << (8 * n);
    bytes.resize(bytes.size() - kFletcherBytes);
    const std::uint32_t sum = fletcher32(bytes);
    // Old libraries wrote it with its bytes exchanged.
    const std::uint32_t exchanged = (sum & 0x00ff00ff) << 8 | (sum >> 8 & 0x00ff00ff);
    if (said != sum && said != exchanged)
        throw badFile(where, "the checksum of a chunk (fletcher32)", "another (damage)");
}

std::vector<std::byte> inflated(const std::vector<std::byte>& packed, std::uint64_t bytes,
                                const std::string& where) {
    constexpr std::uint64_t kMostRatio = 1032; // zlib's technical note
    if (bytes / kMostRatio > packed.size())
        throw badFile(where, std::to_string(bytes) + " bytes of a chunk",
                      std::to_string(packed.size()) + " packed ones, too few for them");
    std::vector<std::byte> out(bytes);
    uLongf got = out.size();
    if (uncompress(reinterpret_cast<Bytef*>(out.data()), &got, reinterpret_cast<const Bytef*>(packed.data()),
                   packed.size()) != Z_OK ||
        got != out.size())
        throw badFile(where, std::to_string(bytes) + " bytes of a chunk packed by deflate", "damage");
    return out;
}

/// Bytes of one place in all numbers lie together.
std::vector<std::byte> unshuffled(const std::vector<std::byte>& bytes, std::size_t each) {
    if (each <= 1 || each > bytes.size())
        return bytes;
    std::vector<std::byte> out(bytes.size());
    const std::size_t count = bytes.size() / each;
    for (std::size_t byte = 0; byte < each; ++byte)
        for (std::size_t n = 0; n < count; ++n)
            out[n * each + byte] = bytes[byte * count + n];
    std::copy(bytes.begin() + static_cast<std::ptrdiff_t>(count * each), bytes.end(),
              out.begin() + static_cast<std::ptrdiff_t>(count * each));
    return out;
}

bool isPartial(const H5Set& set, const H5Chunk& chunk) {
    for (std::size_t axis = 0; axis < chunk.place.size(); ++axis)
        if ((chunk.place[axis] + 1) * set.layout.chunk[axis] > set.space.extents[axis])
            return true;
    return false;
}

} // namespace

std::vector<std::byte> readH5Chunk(const H5File& file, const H5Set& set, const H5Chunk& chunk) {
    const bool isPlain = set.layout.skipsPartial && isPartial(set, chunk);
    // What went into each filter that was used, and what came out of the last.
    std::vector<std::pair<const H5Filter*, std::uint64_t>> used;
    std::uint64_t bytes = set.chunkBytes;
    bool isPacked = false;
    for (std::size_t n = 0; n < set.filters.size() && !isPlain; ++n) {
        if (n < 32 && (chunk.extent.mask >> n & 1) != 0)
            continue;
        const H5Filter& filter = set.filters[n];
        used.emplace_back(&filter, bytes);
        isPacked = isPacked || filter.number == kH5Deflate;
        bytes += filter.number == kH5Fletcher ? kFletcherBytes : 0;
    }
    constexpr std::uint64_t kMostMore = 1 << 16; // deflate adds 5 bytes to 16 KiB that it cannot shrink
    if (isPacked ? chunk.extent.bytes > bytes + bytes / 64 + kMostMore : chunk.extent.bytes != bytes)
        file.refuse(std::to_string(bytes) + " bytes of a chunk of " + set.name,
                    std::to_string(chunk.extent.bytes));
    const std::string& where = file.where();
    std::vector<std::byte> data(chunk.extent.bytes); // within the file: H5Chunks
    file.readAt(chunk.extent.at, data);
    for (auto filter = used.rbegin(); filter != used.rend(); ++filter) {
        if (filter->first->number == kH5Fletcher)
            checkSum(data, where);
        else if (filter->first->number == kH5Deflate)
            data = inflated(data, filter->second, where);
        else
            data =
                unshuffled(data, filter->first->values.empty() ? set.type.bytes : filter->first->values[0]);
    }
    if (data.size() != set.chunkBytes)
        file.refuse(std::to_string(set.chunkBytes) + " bytes of a chunk of " + set.name,
                    std::to_string(data.size()));
    return data;
}

} // namespace tessera

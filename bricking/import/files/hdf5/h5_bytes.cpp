// bricking/import/files/hdf5/h5_bytes.cpp: see h5_bytes.h.
#include "bricking/import/files/hdf5/h5_bytes.h"

#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace tessera {
namespace {

constexpr std::array<unsigned char, 8> kSignature = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};

std::uint64_t littleEndian(std::span<const std::byte> bytes) {
    std::uint64_t value = 0;
    for (std::size_t n = bytes.size(); n-- > 0;)
        value = value << 8 | std::to_integer<std::uint64_t>(bytes[n]);
    return value;
}

} // namespace

std::uint32_t h5Checksum(std::span<const std::byte> bytes) {
    using std::rotl;
    std::uint32_t a = 0xdeadbeef + static_cast<std::uint32_t>(bytes.size()), b = a, c = a;
    const auto add = [&](std::span<const std::byte> twelve) {
        const auto word = [&](std::size_t at) {
            const auto rest = twelve.subspan(std::min(at, twelve.size()));
            return static_cast<std::uint32_t>(
                littleEndian(rest.first(std::min<std::size_t>(rest.size(), 4))));
        };
        a += word(0), b += word(4), c += word(8);
    };
    constexpr std::size_t kStep = 12;
    for (; bytes.size() > kStep; bytes = bytes.subspan(kStep)) {
        add(bytes.first(kStep));
        a -= c, a ^= rotl(c, 4), c += b;
        b -= a, b ^= rotl(a, 6), a += c;
        c -= b, c ^= rotl(b, 8), b += a;
        a -= c, a ^= rotl(c, 16), c += b;
        b -= a, b ^= rotl(a, 19), a += c;
        c -= b, c ^= rotl(b, 4), b += a;
    }
    if (bytes.empty())
        return c;
    add(bytes);
    c ^= b, c -= rotl(b, 14);
    a ^= c, a -= rotl(c, 11);
    b ^= a, b -= rotl(a, 25);
    c ^= b, c -= rotl(b, 16);
    a ^= c, a -= rotl(c, 4);
    b ^= a, b -= rotl(a, 14);
    c ^= b, c -= rotl(b, 24);
    return c;
}

int log2Of(std::uint64_t number) {
    return number == 0 ? 0 : static_cast<int>(std::bit_width(number)) - 1;
}

std::span<const std::byte> H5Bytes::take(std::uint64_t bytes) {
    if (bytes > left())
        refuse("more bytes", "its end");
    const auto taken = std::span(*bytes_).subspan(at_, bytes);
    at_ += bytes;
    return taken;
}

std::uint64_t H5Bytes::number(std::size_t bytes) {
    TESSERA_CHECK(bytes >= 1 && bytes <= 8);
    return littleEndian(take(bytes));
}

std::uint64_t H5Bytes::address() {
    const std::size_t bytes = file_->addressBytes();
    const std::uint64_t at = number(bytes);
    return at == kH5Nowhere >> (64 - 8 * bytes) ? kH5Nowhere : at;
}

std::uint64_t H5Bytes::length() {
    return number(file_->lengthBytes());
}

H5Bytes H5Bytes::part(std::uint64_t bytes) {
    H5Bytes taken = *this;
    skip(bytes);
    taken.end_ = at_;
    return taken;
}

std::string H5Bytes::textOf(std::span<const std::byte> bytes) {
    const auto end = std::ranges::find(bytes, std::byte{0});
    return {reinterpret_cast<const char*>(bytes.data()), static_cast<std::size_t>(end - bytes.begin())};
}

void H5Bytes::requireVersion(int found, int least, int most) const {
    if (found < least || found > most)
        refuse("version " + std::to_string(least) + (least == most ? "" : " to " + std::to_string(most)),
               std::to_string(found));
}

void H5Bytes::refuse(const std::string& expected, const std::string& found) const {
    file_->refuse(expected + " in " + what_, found);
}

H5File::H5File(const std::filesystem::path& path) : file_(path), where_(path.string()) {
    // It may follow a block of the user's.
    for (std::uint64_t at = 0; at < file_.sizeBytes(); at = at == 0 ? 512 : 2 * at) {
        std::array<std::byte, kSignature.size()> mark{};
        if (file_.readSome(at, mark) < mark.size())
            break;
        if (std::memcmp(mark.data(), kSignature.data(), mark.size()) == 0) {
            base_ = at;
            readSuperblock(at);
            return;
        }
    }
    refuse("an HDF5 file", "a file without its signature");
}

void H5File::readSuperblock(std::uint64_t at) {
    std::array<std::byte, 16> head{};
    if (file_.readSome(at, head) < head.size())
        refuse("a superblock", "the end of the file (is it truncated?)");
    const auto byteAt = [&](std::size_t n) { return std::to_integer<std::size_t>(head[n]); };
    const std::size_t version = byteAt(8);
    if (version > 3)
        refuse("an HDF5 file with a superblock of version 0 to 3", std::to_string(version));
    const bool isOld = version < 2;
    addressBytes_ = byteAt(isOld ? 13 : 9);
    lengthBytes_ = byteAt(isOld ? 14 : 10);
    for (const std::size_t bytes : {addressBytes_, lengthBytes_})
        if (bytes != 2 && bytes != 4 && bytes != 8)
            refuse("addresses and lengths of 2, 4 or 8 bytes", std::to_string(bytes));
    const char* const what = "the superblock";
    std::uint64_t begin = 0, end = 0; // as the file had them when it was written
    if (isOld) {
        const std::size_t head = version == 0 ? 24 : 28;
        H5Bytes bytes = block(0, head + 6 * addressBytes_, what);
        bytes.skip(head);
        begin = bytes.address();
        bytes.skip(addressBytes_); // free space
        end = bytes.address();
        if (bytes.address() != kH5Nowhere)
            refuse("one HDF5 file by itself", "a part of several (a driver's block)");
        bytes.skip(addressBytes_); // name of the root
        rootAt_ = bytes.address();
    } else {
        H5Bytes bytes = sealed(0, 16 + 4 * addressBytes_, "\x89HDF", what);
        bytes.skip(8);
        begin = bytes.address();
        bytes.skip(addressBytes_); // its extension
        end = bytes.address();
        rootAt_ = bytes.address();
    }
    if (end < begin || end - begin > sizeBytes())
        refuse("a file of " + std::to_string(end) + " bytes, as its superblock says",
               std::to_string(file_.sizeBytes()) + " (is it truncated?)");
}

void H5File::readAt(std::uint64_t at, std::span<std::byte> out) const {
    if (!has(at, out.size()))
        refuse("data within the file", "some behind its end, at byte " + std::to_string(at));
    file_.readAt(base_ + at, out);
}

std::vector<std::byte> H5File::bytesOf(std::uint64_t at, std::uint64_t bytes, const char* what) const {
    if (!has(at, bytes))
        refuse(std::string(what) + " within the file",
               at == kH5Nowhere ? "none" : "bytes behind its end, at byte " + std::to_string(at));
    if (bytes > kMostBlock)
        refuse(std::string(what) + " of 16 MiB at most", std::to_string(bytes) + " bytes");
    std::vector<std::byte> read(bytes);
    file_.readAt(base_ + at, read);
    return read;
}

H5Bytes H5File::block(std::uint64_t at, std::uint64_t bytes, const char* what) const {
    return {*this, bytesOf(at, bytes, what), what};
}

H5Bytes H5File::sealed(std::uint64_t at, std::uint64_t bytes, std::string_view mark, const char* what) const {
    constexpr std::size_t kSum = 4;
    if (bytes < mark.size() + kSum)
        refuse(what, std::to_string(bytes) + " bytes for it");
    std::vector<std::byte> read = bytesOf(at, bytes, what);
    if (std::memcmp(read.data(), mark.data(), mark.size()) != 0)
        refuse(std::string(what) + " at byte " + std::to_string(at), "another mark (damage)");
    const std::span<const std::byte> all(read);
    if (h5ChecksumsCount && littleEndian(all.last(kSum)) != h5Checksum(all.first(all.size() - kSum)))
        refuse(std::string("the checksum of ") + what + " at byte " + std::to_string(at), "another (damage)");
    read.resize(read.size() - kSum);
    read.erase(read.begin(), read.begin() + static_cast<std::ptrdiff_t>(mark.size()));
    return {*this, std::move(read), what};
}

void H5File::refuse(const std::string& expected, const std::string& found) const {
    throw badFile(where_, expected, found);
}

} // namespace tessera

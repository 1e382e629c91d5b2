// bricking/import/zarr/decompress.cpp: see decompress.h.
#include "bricking/import/zarr/decompress.h"

#include "bricking/store/codec.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstdint>
#include <lz4.h>
#include <zlib.h>
#include <zstd.h>

namespace tessera {
namespace {

constexpr std::size_t kGzipRatio = 1032; // zlib's technical note: deflate shrinks no more
constexpr std::size_t kLz4Ratio = 255;   // a byte of length says at most 255: lz4's block format
constexpr std::size_t kLz4Head = 4;
constexpr std::size_t kZstdRatio = 43691; // blocks of 128 KiB in three bytes: RFC 8878, 3.1.1.2

std::string bytesText(std::uint64_t bytes) {
    return std::to_string(bytes) + " decoded bytes";
}

/// Bytes that an lz4 chunk of numcodecs says it decodes to: four bytes in front of its one block.
std::uint64_t lz4Bytes(std::span<const std::byte> encoded, const std::string& where) {
    if (encoded.size() < kLz4Head)
        throw badFile(where, "lz4 data of at least 4 bytes", std::to_string(encoded.size()));
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < kLz4Head; ++i)
        bytes |= std::to_integer<std::uint64_t>(encoded[i]) << (8 * i);
    return bytes;
}

void requireRatio(std::size_t encoded, std::size_t decoded, std::size_t ratio, const std::string& where) {
    if (decoded / ratio > encoded)
        throw badFile(where, bytesText(decoded), std::to_string(encoded) + " bytes, too few for them");
}

void inflateAll(std::span<const std::byte> encoded, std::span<std::byte> out, int windowBits,
                const std::string& where) {
    z_stream stream{};
    if (inflateInit2(&stream, windowBits) != Z_OK)
        throw Error(where + ": zlib could not begin");
    struct End {
        z_stream& stream;
        ~End() { inflateEnd(&stream); }
    } const end{stream};
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(encoded.data()));
    stream.avail_in = static_cast<uInt>(encoded.size()); // chunks are below 2 GiB
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    while (true) {
        const int result = inflate(&stream, Z_FINISH);
        if (result != Z_STREAM_END)
            throw badFile(where, "gzip data of " + bytesText(out.size()),
                          stream.msg                                       ? std::string(stream.msg)
                          : stream.avail_out == 0 && result == Z_BUF_ERROR ? std::string("more of them")
                                                                           : std::string("a cut stream"));
        if (stream.avail_in == 0 || stream.avail_out == 0)
            break;
        if (inflateReset(&stream) != Z_OK) // gzip files may have several members
            throw badFile(where, "gzip data", "damage");
    }
    if (stream.avail_out != 0)
        throw badFile(where, bytesText(out.size()), std::to_string(out.size() - stream.avail_out));
    if (stream.avail_in != 0)
        throw badFile(where, bytesText(out.size()), std::to_string(stream.avail_in) + " bytes behind them");
}

} // namespace

void requireChunkSize(ZarrCodec codec, std::span<const std::byte> encoded, std::size_t decodedBytes,
                      const std::string& where) {
    switch (codec) {
    case ZarrCodec::blosc:
        if (const std::size_t bytes = bloscBytes(encoded, where); bytes != decodedBytes)
            throw badFile(where, bytesText(decodedBytes), std::to_string(bytes));
        return requireRatio(encoded.size(), decodedBytes, kZstdRatio, where);
    case ZarrCodec::zstd: {
        const unsigned long long bytes = ZSTD_getFrameContentSize(encoded.data(), encoded.size());
        if (bytes == ZSTD_CONTENTSIZE_ERROR)
            throw badFile(where, "a zstd frame", "something else");
        if (bytes != ZSTD_CONTENTSIZE_UNKNOWN && bytes > decodedBytes)
            throw badFile(where, bytesText(decodedBytes), std::to_string(bytes));
        return requireRatio(encoded.size(), decodedBytes, kZstdRatio, where);
    }
    case ZarrCodec::lz4:
        if (const std::uint64_t bytes = lz4Bytes(encoded, where); bytes != decodedBytes)
            throw badFile(where, bytesText(decodedBytes), std::to_string(bytes));
        return requireRatio(encoded.size(), decodedBytes, kLz4Ratio, where);
    case ZarrCodec::gzip:
    case ZarrCodec::zlib:
        return requireRatio(encoded.size(), decodedBytes, kGzipRatio, where);
    case ZarrCodec::crc32c:
        return;
    }
}

void decompress(ZarrCodec codec, std::span<const std::byte> encoded, std::span<std::byte> out,
                const std::string& where) {
    constexpr int kWindow = 15, kGzipHeader = 16;
    switch (codec) {
    case ZarrCodec::blosc:
        return decodeBlosc(encoded, out, where);
    case ZarrCodec::zstd: {
        const std::size_t bytes = ZSTD_decompress(out.data(), out.size(), encoded.data(), encoded.size());
        if (ZSTD_isError(bytes))
            throw badFile(where, "zstd data of " + bytesText(out.size()), ZSTD_getErrorName(bytes));
        if (bytes != out.size())
            throw badFile(where, bytesText(out.size()), std::to_string(bytes));
        return;
    }
    case ZarrCodec::lz4: {
        const int bytes = LZ4_decompress_safe(reinterpret_cast<const char*>(encoded.data() + kLz4Head),
                                              reinterpret_cast<char*>(out.data()),
                                              static_cast<int>(encoded.size() - kLz4Head),
                                              static_cast<int>(out.size())); // chunks are below 2 GiB
        if (bytes < 0 || static_cast<std::size_t>(bytes) != out.size())
            throw badFile(where, "lz4 data of " + bytesText(out.size()),
                          bytes < 0 ? "damage" : std::to_string(bytes));
        return;
    }
    case ZarrCodec::gzip:
        return inflateAll(encoded, out, kWindow + kGzipHeader, where);
    case ZarrCodec::zlib:
        return inflateAll(encoded, out, kWindow, where);
    case ZarrCodec::crc32c:
        TESSERA_CHECK(codec != ZarrCodec::crc32c);
    }
}

} // namespace tessera

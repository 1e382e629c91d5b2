// bricking/store/codec.cpp: see codec.h.
#include "bricking/store/codec.h"

#include "bricking/store/crc32c.h"
#include "core/base/error.h"

#include <blosc.h> // the _ctx calls: thread-safe, no global state
#include <cstdio>
#include <cstring>

namespace tessera {
namespace {

constexpr int kBloscLevel = 5; // with lz4 and bitshuffle: about 0.5 GB/s in, 1.4 GB/s out on CT

std::string hex(std::uint32_t value) {
    char text[16];
    std::snprintf(text, sizeof text, "%08x", static_cast<unsigned>(value));
    return text;
}

} // namespace

std::size_t encodedBound(std::size_t rawBytes) {
    return rawBytes + BLOSC_MAX_OVERHEAD + kCrcBytes;
}

EncodedChunk encodeChunk(std::span<const std::byte> raw, std::size_t valueBytes, std::span<std::byte> out) {
    TESSERA_CHECK(out.size() >= encodedBound(raw.size()));
    const int bytes = blosc_compress_ctx(kBloscLevel, BLOSC_BITSHUFFLE, valueBytes, raw.size(), raw.data(),
                                         out.data(), out.size() - kCrcBytes, BLOSC_LZ4_COMPNAME, 0, 1);
    if (bytes <= 0)
        throw Error("blosc: compression failed with code " + std::to_string(bytes));
    EncodedChunk chunk;
    chunk.crc = crc32c(out.first(static_cast<std::size_t>(bytes)));
    std::memcpy(out.data() + bytes, &chunk.crc, kCrcBytes);
    chunk.bytes = static_cast<std::size_t>(bytes) + kCrcBytes;
    return chunk;
}

void decodeChunk(std::span<const std::byte> encoded, std::span<std::byte> out, const std::string& where) {
    if (encoded.size() < BLOSC_MIN_HEADER_LENGTH + kCrcBytes)
        throw badFile(where, "a blosc header and a checksum", std::to_string(encoded.size()) + " bytes");
    const auto payload = encoded.first(encoded.size() - kCrcBytes);
    std::uint32_t expected = 0;
    std::memcpy(&expected, encoded.data() + payload.size(), kCrcBytes);
    if (const std::uint32_t found = crc32c(payload); found != expected)
        throw badFile(where, "checksum " + hex(expected), hex(found) + "; the data is damaged");
    std::size_t rawBytes = 0;
    if (blosc_cbuffer_validate(payload.data(), payload.size(), &rawBytes) != 0)
        throw badFile(where, "a valid blosc buffer", "one with a wrong header");
    if (rawBytes != out.size())
        throw badFile(where, std::to_string(out.size()) + " decoded bytes", std::to_string(rawBytes));
    const int bytes = blosc_decompress_ctx(payload.data(), out.data(), out.size(), 1);
    if (bytes < 0 || static_cast<std::size_t>(bytes) != out.size())
        throw badFile(where, "a blosc buffer that decodes", "blosc error " + std::to_string(bytes));
}

} // namespace tessera

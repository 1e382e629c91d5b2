// bricking/store/codec.h: one chunk to bytes and back: as its store's codec says, then CRC-32C. The writer's
// parameters are fixed; the reader uses blosc's own header, after checking its size. CRC-32C, the
// checksum that ends every codec chain of a store. Castagnoli polynomial, reflected 0x82F63B78, initial value
// and final xor all ones (RFC 3720, appendix B.4).
#pragma once

#include "core/base/names.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tessera {

enum class Codec : std::uint8_t {
    lz4,  // blosc(lz4, level 5, bitshuffle)
    zstd, // blosc(zstd, level 3, bitshuffle): smaller, and slower to write
    none, // the values as they are
    // By the discrete cosine transform in steps of so much (dct_chunk.h), blosc(zstd) behind it, where that
    // is without loss: of values that withDctSteps() made. Else as zstd. Numbers of one or two bytes.
    dct8,
    dct16,
    dct32,
    dct64,
    dct128,
};
template <> const NameTable<Codec>& namesOf<Codec>();
/// The codecs of whole stores: "lz4", "zstd" and "none".
const std::vector<std::string>& losslessCodecNames();
/// Of a codec by the discrete cosine transform; else 0.
int dctStep(Codec codec);
/// What blosc is told of a codec other than none, as metadata have it.
struct BloscParameters {
    const char* name;
    int level;
};
BloscParameters bloscParameters(Codec codec);

/// CRC-32C of bytes; crc32c("123456789") = 0xE3069283.
/// @param before  the CRC of the preceding bytes, to continue an earlier call
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0);
/// The same on processors without an instruction for it.
std::uint32_t crc32cByTables(std::span<const std::byte> bytes, std::uint32_t before = 0);

constexpr std::size_t kCrcBytes = 4;

/// Upper bound on the encoded size of rawBytes.
std::size_t encodedBound(std::size_t rawBytes);

struct EncodedChunk {
    std::size_t bytes = 0; // bytes used in the output buffer, CRC included
    std::uint32_t crc = 0;
};
/// Encodes raw (values of valueBytes each, little-endian) into out, at least encodedBound(raw.size()) long.
/// Deterministic: the same input gives the same bytes on every machine. Thread-safe.
EncodedChunk encodeChunk(std::span<const std::byte> raw, std::size_t valueBytes, std::span<std::byte> out,
                         Codec codec = Codec::lz4);

/// Encodes by blosc alone, into at most out.size() bytes; at least raw.size() + 16 suffice.
/// @return  bytes used
std::size_t encodeBlosc(std::span<const std::byte> raw, std::size_t valueBytes, std::span<std::byte> out,
                        Codec codec);
/// The decoded size that a blosc buffer's header states. Throws InputError that begins with where.
std::size_t bloscBytes(std::span<const std::byte> encoded, const std::string& where);
/// Decodes a blosc buffer into exactly out.size() bytes. Thread-safe.
/// Throws InputError that begins with where, when the header or the size is wrong.
void decodeBlosc(std::span<const std::byte> encoded, std::span<std::byte> out, const std::string& where);
/// Takes the checksum off the end. Throws InputError that begins with where, when it is wrong.
std::span<const std::byte> withoutCrc(std::span<const std::byte> encoded, const std::string& where);

/// Both: decodes a chunk into exactly out.size() bytes. Thread-safe.
/// Throws InputError that begins with where, when the checksum, the header or the size is wrong.
void decodeChunk(std::span<const std::byte> encoded, std::span<std::byte> out, const std::string& where,
                 Codec codec = Codec::lz4);

} // namespace tessera

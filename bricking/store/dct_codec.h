// bricking/store/dct_codec.h: the codecs dct8 to dct128: coefficients of a chunk (dct_chunk.h) in blosc. A
// chunk that they would change is kept as it is, so they lose nothing: what is lost was lost by
// withDctSteps() before.
#pragma once

#include "bricking/store/codec.h"

namespace tessera {

/// Changes a chunk to values that a codec by the discrete cosine transform keeps in few bytes. What is of one
/// value beyond a box at the chunk's origin, as beyond a volume's edge, stays. Numbers of two bytes without a
/// sign stay where one is above 32767. raw: kChunkExtent^3 numbers of one or two bytes.
void withDctSteps(std::span<std::byte> raw, std::size_t valueBytes, bool hasSign, Codec codec);

/// @param out  encodedBound(raw.size()) without the checksum
/// @return  bytes used
std::size_t encodeByDct(std::span<const std::byte> raw, std::size_t valueBytes, std::span<std::byte> out,
                        Codec codec);
/// Throws InputError that begins with where.
void decodeByDct(std::span<const std::byte> coded, std::span<std::byte> out, const std::string& where,
                 Codec codec);

} // namespace tessera

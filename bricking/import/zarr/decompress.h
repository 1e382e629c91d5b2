// bricking/import/zarr/decompress.h: the compressions of Zarr's chunks, each of a known decoded size.
#pragma once

#include "bricking/import/zarr/zarr_array.h"

#include <cstddef>
#include <span>
#include <string>

namespace tessera {

/// Throws InputError that begins with `where` if the first bytes say that they decode to another size, or are
/// too few for it. For a check before memory is taken.
void requireChunkSize(ZarrCodec codec, std::span<const std::byte> encoded, std::size_t decodedBytes,
                      const std::string& where);

/// Decodes into exactly out.size() bytes; not for crc32c. Throws InputError that begins with `where` for
/// damage, and for another size.
void decompress(ZarrCodec codec, std::span<const std::byte> encoded, std::span<std::byte> out,
                const std::string& where);

} // namespace tessera

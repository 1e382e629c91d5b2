// bricking/store/crc32c.h: CRC-32C, the checksum that ends every codec chain of a store.
// Castagnoli polynomial, reflected 0x82F63B78, initial value and final xor all ones (RFC 3720, appendix B.4).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera {

/// CRC-32C of bytes; crc32c("123456789") = 0xE3069283.
/// @param before  the CRC of the preceding bytes, to continue an earlier call
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0);
/// The same on processors without an instruction for it.
std::uint32_t crc32cByTables(std::span<const std::byte> bytes, std::uint32_t before = 0);

} // namespace tessera

// bricking/store/crc32c.cpp: by the instruction for it where the processor has one; else eight bytes a step
// through eight tables made at compile time.
#include "bricking/store/crc32c.h"

#include <array>
#include <bit>
#include <cstring>

namespace tessera {
namespace {

using Table = std::array<std::array<std::uint32_t, 256>, 8>;

/// tables[n][b]: what byte b contributes when n more zero bytes follow it.
constexpr Table makeTables() {
    Table tables{};
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
        std::uint32_t value = byte;
        for (int bit = 0; bit < 8; ++bit)
            value = (value >> 1) ^ ((value & 1) ? 0x82F63B78u : 0u);
        tables[0][byte] = value;
    }
    for (std::size_t n = 1; n < 8; ++n)
        for (std::size_t byte = 0; byte < 256; ++byte) {
            const std::uint32_t shorter = tables[n - 1][byte];
            tables[n][byte] = (shorter >> 8) ^ tables[0][shorter & 0xFF];
        }
    return tables;
}
constexpr Table kTables = makeTables();
static_assert(std::endian::native == std::endian::little, "words are loaded in the file's byte order");

#if defined(__x86_64__)
__attribute__((target("sse4.2"))) std::uint32_t byInstruction(std::span<const std::byte> bytes,
                                                              std::uint32_t before) {
    std::uint64_t crc = ~before;
    const std::byte* at = bytes.data();
    std::size_t left = bytes.size();
    for (; left >= 8; left -= 8, at += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, at, 8);
        crc = __builtin_ia32_crc32di(crc, word);
    }
    auto last = static_cast<std::uint32_t>(crc);
    for (; left > 0; --left, ++at)
        last = __builtin_ia32_crc32qi(last, static_cast<std::uint8_t>(*at));
    return ~last;
}
bool hasInstruction() {
    return __builtin_cpu_supports("sse4.2") != 0;
}
#endif

} // namespace

std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) {
#if defined(__x86_64__)
    static const bool instruction = hasInstruction();
    if (instruction)
        return byInstruction(bytes, before);
#endif
    return crc32cByTables(bytes, before);
}

std::uint32_t crc32cByTables(std::span<const std::byte> bytes, std::uint32_t before) {
    std::uint32_t crc = ~before;
    const std::byte* at = bytes.data();
    std::size_t left = bytes.size();
    for (; left >= 8; left -= 8, at += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, at, 8);
        word ^= crc;
        crc = 0;
        for (std::size_t n = 0; n < 8; ++n)
            crc ^= kTables[7 - n][(word >> (8 * n)) & 0xFF];
    }
    for (; left > 0; --left, ++at)
        crc = (crc >> 8) ^ kTables[0][(crc ^ static_cast<std::uint32_t>(*at)) & 0xFF];
    return ~crc;
}

} // namespace tessera

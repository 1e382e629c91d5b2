// bricking/import/files/vdb/vdb_values.h: the values of a node of an OpenVDB tree: packed, without those that
// are inactive, as halves. Private to the reader.
#pragma once

#include "bricking/import/files/vdb/vdb_bytes.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

constexpr std::uint32_t kVdbZip = 1, kVdbActiveMask = 2, kVdbBlosc = 4;

/// A bit for each value, the lowest of a byte first.
using VdbMask = std::span<const std::byte>;
inline bool isOn(VdbMask mask, std::size_t n) {
    return (std::to_integer<unsigned>(mask[n / 8]) >> (n % 8) & 1) != 0;
}

class VdbValues {
  public:
    VdbValues(std::uint32_t compression, bool isHalf, float background)
        : compression_(compression), isHalf_(isHalf), background_(background) {}

    /// As many values as `active` has bits. Throws InputError naming the file for damage, and for packed
    /// bytes that do not give exactly these.
    void read(VdbBytes& bytes, VdbMask active, std::span<float> out);
    /// Passes over them, without unpacking.
    void skip(VdbBytes& bytes, VdbMask active);

  private:
    /// What stands before the numbers.
    struct Inactive {
        float values[2] = {0, 0};
        std::vector<std::byte> selection; // which of both; empty: the first
        std::size_t stored = 0;           // numbers that follow
    };
    Inactive beginningOf(VdbBytes& bytes, VdbMask active) const;
    std::size_t bytesOf(std::size_t count) const;
    /// The length of what follows; 0 where the numbers are not packed.
    std::uint64_t packedLength(VdbBytes& bytes, std::size_t plain) const;
    void readNumbers(VdbBytes& bytes, std::span<float> out);

    std::uint32_t compression_;
    bool isHalf_;
    float background_;
    std::vector<std::byte> packed_, plain_;
    std::vector<float> numbers_;
};

} // namespace tessera

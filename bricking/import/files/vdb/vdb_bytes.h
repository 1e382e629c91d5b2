// bricking/import/files/vdb/vdb_bytes.h: a part of an OpenVDB file, read forward: numbers, words, what is
// passed over. Private to the reader.
#pragma once

#include "bricking/import/source/source_files.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace tessera {

class VdbBytes {
  public:
    /// @param file  must outlive it
    /// @param end  of the part; at most the file's size
    /// @param portionBytes  that are read at a time
    VdbBytes(const InputFile& file, std::uint64_t at, std::uint64_t end,
             std::size_t portionBytes = std::size_t{64} << 10)
        : file_(file), at_(at), end_(end), portion_(portionBytes) {}

    std::uint64_t at() const { return at_; }
    std::uint64_t left() const { return end_ - at_; }
    /// These throw InputError naming the file at the end of the part.
    void read(std::span<std::byte> out);
    void skip(std::uint64_t bytes);
    /// Little endian, as all machines of the library are.
    template <class T> T number() {
        std::byte bytes[sizeof(T)];
        read(bytes);
        T value;
        std::memcpy(&value, bytes, sizeof value);
        return value;
    }
    /// Of at most 4096 bytes.
    std::string word();

    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const;

  private:
    void require(std::uint64_t bytes) const;

    const InputFile& file_;
    std::uint64_t at_, end_;
    std::size_t portion_;
    std::vector<std::byte> held_; // from heldAt_ on
    std::uint64_t heldAt_ = 0;
};

} // namespace tessera

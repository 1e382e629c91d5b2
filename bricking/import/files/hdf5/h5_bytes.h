// bricking/import/files/hdf5/h5_bytes.h: an HDF5 file read by its addresses, and a part of it in memory, read
// forward. Private to the reader. Rules: HDF5 File Format Specification 3.0.
#pragma once

#include "bricking/import/source/source_files.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tessera {

/// What the file says in place of an address: nothing is there.
constexpr std::uint64_t kH5Nowhere = ~std::uint64_t{0};

class H5File;

/// A part of a file.
class H5Bytes {
  public:
    /// @param file  must outlive it
    /// @param what  "the links of a group": for messages; must outlive it
    H5Bytes(const H5File& file, std::vector<std::byte> bytes, const char* what)
        : file_(&file), bytes_(std::make_shared<const std::vector<std::byte>>(std::move(bytes))),
          end_(bytes_->size()), what_(what) {}

    std::size_t left() const { return end_ - at_; }
    /// These throw InputError naming the file at the end of the part.
    /// @param bytes  1 to 8, little endian
    std::uint64_t number(std::size_t bytes);
    int byte() { return static_cast<int>(number(1)); }
    /// kH5Nowhere: none.
    std::uint64_t address();
    std::uint64_t length();
    void skip(std::uint64_t bytes) { static_cast<void>(take(bytes)); }
    std::span<const std::byte> take(std::uint64_t bytes);
    /// A part of it that is read by itself.
    H5Bytes part(std::uint64_t bytes);
    /// Up to the first zero byte.
    static std::string textOf(std::span<const std::byte> bytes);
    void requireVersion(int found, int least, int most) const;

    const H5File& file() const { return *file_; }
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const;

  private:
    const H5File* file_;
    std::shared_ptr<const std::vector<std::byte>> bytes_; // copies share them
    std::size_t at_ = 0, end_ = 0;
    const char* what_;
};

class H5File {
  public:
    /// Most bytes of what describes data, in one piece.
    static constexpr std::uint64_t kMostBlock = std::uint64_t{16} << 20;

    /// Reads the superblock. Throws InputError naming the file for one that is none, of another version than
    /// 0 to 3, of several files, or shorter than it says.
    explicit H5File(const std::filesystem::path& path);

    const std::string& where() const { return where_; }
    std::uint64_t rootAt() const { return rootAt_; }
    std::size_t addressBytes() const { return addressBytes_; }
    std::size_t lengthBytes() const { return lengthBytes_; }
    /// Of what addresses count.
    std::uint64_t sizeBytes() const { return file_.sizeBytes() - base_; }

    /// Throws InputError naming the file for bytes behind its end.
    void readAt(std::uint64_t at, std::span<std::byte> out) const;
    bool has(std::uint64_t at, std::uint64_t bytes) const {
        return at <= sizeBytes() && bytes <= sizeBytes() - at;
    }
    /// Throws likewise before it takes memory, and for more than kMostBlock.
    H5Bytes block(std::uint64_t at, std::uint64_t bytes, const char* what) const;
    /// What is between a mark of four letters and a checksum, which are compared. `bytes` counts both.
    H5Bytes sealed(std::uint64_t at, std::uint64_t bytes, std::string_view mark, const char* what) const;
    [[noreturn]] void refuse(const std::string& expected, const std::string& found) const;

  private:
    void readSuperblock(std::uint64_t at);
    std::vector<std::byte> bytesOf(std::uint64_t at, std::uint64_t bytes, const char* what) const;

    InputFile file_;
    std::string where_;
    std::uint64_t base_ = 0, rootAt_ = 0;
    std::size_t addressBytes_ = 8, lengthBytes_ = 8;
};

/// False: checksums are not compared. For tests of files whose damage has checksums that fit.
inline bool h5ChecksumsCount = true;

/// Bob Jenkins' lookup3, as the format's checksums are.
std::uint32_t h5Checksum(std::span<const std::byte> bytes);

/// The number of bits up to the highest that is set, less one; 0 of 0.
int log2Of(std::uint64_t number);
/// Bytes that hold all numbers up to this one.
inline std::size_t bytesToHold(std::uint64_t most) {
    return static_cast<std::size_t>(log2Of(most) / 8 + 1);
}

} // namespace tessera

// bricking/import/source/input_file.h: a source file read by position; its errors name the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace tessera {

/// A regular file opened for reading. Move-only; closes itself.
class InputFile {
  public:
    /// Throws InputError naming the path if it is missing, not a regular file, or not readable.
    explicit InputFile(std::filesystem::path path);
    InputFile(InputFile&& other) noexcept;
    InputFile& operator=(InputFile&& other) noexcept;
    ~InputFile();

    const std::filesystem::path& path() const { return path_; }
    std::uint64_t sizeBytes() const { return sizeBytes_; }

    /// Fills out from byte `offset` on. Throws InputError if the file ends earlier, Error if the disk fails.
    void readAt(std::uint64_t offset, std::span<std::byte> out) const;
    /// Reads up to out.size() bytes, fewer only at the end of the file. Throws Error if the disk fails.
    std::size_t readSome(std::uint64_t offset, std::span<std::byte> out) const;

  private:
    std::filesystem::path path_;
    std::uint64_t sizeBytes_ = 0;
    int descriptor_ = -1;
};

} // namespace tessera

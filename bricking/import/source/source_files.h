// bricking/import/source/source_files.h: files of importers: a source file read by position, and a temporary
// file without a name.
#pragma once

#include "core/base/shown_text.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace tessera {

/// A file name made printable, for one line of text.
inline std::string printableName(const std::filesystem::path& path) {
    return printable(path.string());
}

// A source file read by position; its errors name the file.

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

// A temporary file without a name. The system frees it when the process ends, however it ends.

class SpoolFile {
  public:
    /// In `folder`, or if it is empty in the system's folder for temporary files. Throws Error if that fails.
    explicit SpoolFile(const std::filesystem::path& folder);
    ~SpoolFile();
    SpoolFile(const SpoolFile&) = delete;
    SpoolFile& operator=(const SpoolFile&) = delete;

    /// Both throw Error naming the folder, for example when the disk is full.
    void append(std::span<const std::byte> bytes);
    void readAt(std::uint64_t offset, std::span<std::byte> out) const;

  private:
    std::filesystem::path folder_;
    std::uint64_t sizeBytes_ = 0;
    int descriptor_ = -1;
};

} // namespace tessera

// core/base/output_file.h: writes every single file that is a result (picture, page, table, scene). It is
// written under another name beside the target, every step is checked, and it is renamed when it is whole.
#pragma once

#include "core/base/file_handle.h"
#include "core/base/interrupt.h" // TemporaryPath

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

namespace tessera {

/// Where a result of that name lies: links are followed, also one to what does not exist yet.
/// Throws InputError naming path for links that go round in circles.
std::filesystem::path outputTarget(const std::filesystem::path& path);

/// Throws InputError naming path when no file can be written there: a folder, a device, a pipe or a socket
/// has the name. Likewise where the file is read-only, or its folder is missing or may not be written in.
void checkOutputFile(const std::filesystem::path& path);

/// A file on its way. What was there before stays until finish(), and for good if that is never reached.
class OutputFile {
  public:
    /// Makes ".NAME.tessera-PID-N" beside the file and removes those that dead processes left there.
    /// Throws InputError as checkOutputFile() does, Error when it cannot be made.
    explicit OutputFile(const std::filesystem::path& path);
    /// Removes what is unfinished.
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// Of the unfinished file, for programs that write by name; they must write into it, not replace it.
    const std::filesystem::path& path() const { return path_; }
    /// Throws Error naming the file that it is to be.
    void writeAt(std::uint64_t offset, std::span<const std::byte> bytes);
    /// Waits until the disk has it, closes and renames; the old file's permissions stay.
    /// Throws Error naming the file that it is to be, which is then as it was.
    void finish();

  private:
    std::filesystem::path shown_, target_, path_;
    FileHandle file_;
    std::optional<TemporaryPath> unfinished_;
    bool renamed_ = false;
};

/// A whole file. Throws as OutputFile does.
void writeOutputFile(const std::filesystem::path& path, std::string_view text);

/// Waits until standard output has taken what was printed. Throws Error when it has not: a full disk, a
/// closed descriptor.
void finishStandardOutput();

} // namespace tessera

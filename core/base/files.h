// core/base/files.h: an owned file descriptor, and the refusal of pipes and devices before they are opened:
// reading one may block or never end.
#pragma once

#include "core/base/error.h"

#include <filesystem>
#include <string>
#include <system_error>

namespace tessera {

/// An owned file descriptor; move-only.
class FileHandle {
  public:
    FileHandle() = default;
    explicit FileHandle(int descriptor) : descriptor_(descriptor) {}
    FileHandle(FileHandle&& other) noexcept;
    FileHandle& operator=(FileHandle&& other) noexcept;
    ~FileHandle();
    int descriptor() const { return descriptor_; }
    /// Closes a file that was written: some file systems report a failed write only here. Throws Error naming
    /// shown.
    void close(const std::string& shown);

  private:
    int descriptor_ = -1;
};

/// True if path is a pipe, a socket or a device. Links are followed.
inline bool isPipeOrDevice(const std::filesystem::path& path) {
    std::error_code ignored;
    const std::filesystem::file_status status = std::filesystem::status(path, ignored);
    return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status) &&
           !std::filesystem::is_directory(status);
}

/// Throws InputError naming a pipe, a socket or a device.
inline void refusePipeOrDevice(const std::filesystem::path& path) {
    if (isPipeOrDevice(path))
        throw badFile(path.string(), "a regular file", "a pipe, a socket or a device");
}

} // namespace tessera

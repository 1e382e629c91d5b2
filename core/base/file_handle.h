// core/base/file_handle.h: an owned file descriptor.
#pragma once

#include <string>

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

} // namespace tessera

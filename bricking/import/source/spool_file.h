// bricking/import/source/spool_file.h: a temporary file without a name. The system frees it when the process
// ends, however it ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace tessera {

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

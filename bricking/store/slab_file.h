// bricking/store/slab_file.h: SlabFile: a slab of a level that has no room in memory, in a file without a
// name. The system frees it when the process ends, however it ends.
#pragma once

#include "core/base/files.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace tessera {

/// Throws Error naming the folder if its disk has less room.
/// @param what  that is to be written there
void requireDiskRoom(const std::filesystem::path& folder, std::uint64_t bytes, std::string_view what);

class SlabFile {
  public:
    /// Throws Error naming the folder if it cannot be made there.
    explicit SlabFile(const std::filesystem::path& folder);

    /// Both throw Error naming the folder, for example when the disk is full.
    void write(std::uint64_t offset, std::span<const std::byte> bytes);
    /// What was written there.
    void read(std::uint64_t offset, std::span<std::byte> out) const;

  private:
    std::filesystem::path folder_;
    FileHandle file_;
};

} // namespace tessera

// viewer/cli/input/fetched_file.h: FetchedFile: a file of labels or of a mesh behind an address as a file on
// a disk, for readers that need one.
#pragma once

#include "core/base/error.h"
#include "core/base/program_folders.h" // ScratchFolder

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace tessera {

class FetchedFile {
  public:
    /// Fetches a file behind an address whole, in pieces, into a temporary folder, by its own name; a path on
    /// a disk stays as it is. Blocks are kept as those of volumes are (remote_input.h), for the next time.
    /// @param what  "labels in one file": for messages
    /// Throws InputError naming the address where nothing is there, for a file that is larger than
    /// mostBytes(), and as RemoteFiles does; Error where the disk has no room.
    FetchedFile(const std::filesystem::path& given, const std::string& what);

    /// On a disk.
    const std::filesystem::path& path() const { return path_; }
    bool isFetched() const { return folder_.has_value(); }
    /// Calls body; what it throws names the address in place of the temporary file.
    template <typename Body> auto reading(const Body& body) const {
        if (!isFetched())
            return body();
        try {
            return body();
        } catch (const InputError& problem) {
            throw renamed(problem);
        }
    }
    /// The part of the cache that blocks of addresses have: a larger file would not stay there.
    static std::uint64_t mostBytes();

  private:
    InputError renamed(const InputError& problem) const;
    std::filesystem::path given_, path_;
    std::optional<ScratchFolder> folder_;
};

} // namespace tessera

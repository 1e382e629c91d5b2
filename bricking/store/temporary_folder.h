// bricking/store/temporary_folder.h: a folder that gets its final name only when it is whole.
#pragma once

#include "core/base/file_handle.h"
#include "core/base/interrupt.h" // TemporaryPath

#include <filesystem>
#include <optional>

namespace tessera {

class TemporaryFolder {
  public:
    /// Makes ".NAME.importing-PID-N" beside target (where target's links lead), on the same file system, so
    /// that a rename is atomic. Takes away what dead processes left there: see recoverFolders().
    /// Throws InputError when the target's parent is missing, Error when the folder cannot be made.
    explicit TemporaryFolder(const std::filesystem::path& target);
    /// Removes the folder and all that is in it, unless it was renamed.
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    /// Makes the folder tree durable, unless told not to wait for that, and renames it to the target.
    /// @param replace  exchange it with an existing target in one step where the file system can, and remove
    ///     that afterwards; else InputError where there is a target by now
    /// Throws Error; the target is then as it was.
    void commit(bool durable, bool replace);

  private:
    std::filesystem::path target_, path_;
    FileHandle owned_;
    std::optional<TemporaryPath> unfinished_;
    bool committed_ = false;
};

/// Gives `from` the name `to`, on one file system. With `replace` whatever has that name is removed once `to`
/// is the new one; without it InputError says that there is one. Killed at any moment, `to` is the old one or
/// the new one, or recoverFolders() makes it so.
/// @param exchanges  false: as on a file system that cannot exchange two names in one step
void publishFolder(const std::filesystem::path& from, const std::filesystem::path& to, bool replace,
                   bool exchanges = true);

/// In `folder`: removes unfinished stores (".NAME.zarr.importing-PID-N") of dead processes, and gives an old
/// store its name back where the process that was replacing it died between two renames.
void recoverFolders(const std::filesystem::path& folder);

} // namespace tessera

// bricking/store/temporary_folder.h: a folder that gets its final name only when it is complete.
#pragma once

#include "core/base/files.h"
#include "core/base/interrupt.h" // TemporaryPath

#include <filesystem>
#include <optional>

namespace tessera {

class TemporaryFolder {
  public:
    /// Makes ".NAME.importing-PID-N" beside target (where target's links lead), on the same file system, so
    /// that a rename is atomic. Removes folders of dead processes there: see recoverFolders(). Throws
    /// InputError if the target's parent is missing, Error if the folder cannot be made.
    explicit TemporaryFolder(const std::filesystem::path& target);
    /// Removes the folder with its content, unless it was renamed.
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    /// Makes the folder tree durable, if requested, and renames it to the target.
    /// @param replace  exchange it with an existing target, in one step if the file system can, and remove
    ///     that afterwards; else InputError if there is a target
    /// Throws Error; the target is then unchanged.
    void commit(bool durable, bool replace);

  private:
    std::filesystem::path target_, path_;
    FileHandle owned_;
    std::optional<TemporaryPath> unfinished_;
    bool committed_ = false;
};

/// Renames `from` to `to`, on one file system. With `replace` an existing `to` is removed after the rename;
/// without it InputError says that it exists. After a kill at any moment `to` is the old one or the new one,
/// or recoverFolders() makes it so.
/// @param exchanges  false: as on a file system that cannot exchange names in one step
void publishFolder(const std::filesystem::path& from, const std::filesystem::path& to, bool replace,
                   bool exchanges = true);

/// In `folder`: removes unfinished stores (".NAME.zarr.importing-PID-N") of dead processes, and restores the
/// name of an old store if the process that replaced it died between two renames.
void recoverFolders(const std::filesystem::path& folder);

} // namespace tessera

// bricking/store/store_files.h: the files of a store: the few operations that it needs, with errors that name
// the file, and the folder in which it is written. Reading follows no link below the store's folder. A store
// that is read may lie behind an address (remote_files.h).
#pragma once

#include "bricking/store/remote_files.h"
#include "core/base/files.h"
#include "core/base/interrupt.h" // TemporaryPath

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tessera {

/// A folder that is read: on a disk, or behind an address.
struct StoreFolder {
    FileHandle disk;
    std::optional<RemotePlace> remote; // takes the place of `disk`
};
/// A file that is read, likewise.
struct StoreFile {
    FileHandle disk;
    std::shared_ptr<RemoteFiles> remote; // takes the place of `disk`
    std::string name = {};               // in `remote`
};

/// Opens a folder for openIn(). Throws InputError naming it. What lies behind an address is not looked for.
StoreFolder openFolder(const std::filesystem::path& path);

/// Opens a regular file below folder for reading.
/// @param relative  names joined by '/', none of them "", "." or ".."
/// @param shown  the folder's path, for messages
/// @return nullopt if the file or a folder of its path is missing
/// Throws InputError naming the path for links, for anything but a regular file, and if it cannot be opened.
std::optional<StoreFile> openIn(const StoreFolder& folder, std::string_view relative,
                                const std::filesystem::path& shown);

std::uint64_t fileSize(const StoreFile& file, const std::string& shown);
/// Fills out from offset. Throws InputError naming the file if it ends too early or cannot be read.
void readAt(const StoreFile& file, std::uint64_t offset, std::span<std::byte> out, const std::string& shown);
/// The whole file as text; nullopt if missing. Throws InputError if it is larger than limitBytes.
std::optional<std::string> readText(const StoreFolder& folder, std::string_view relative,
                                    const std::filesystem::path& shown, std::uint64_t limitBytes);

/// Opens a file for writing; creates it if it is missing. Throws Error naming it.
FileHandle openForWriting(const std::filesystem::path& path);
void writeAt(const FileHandle& file, std::uint64_t offset, std::span<const std::byte> bytes,
             const std::filesystem::path& shown);
/// Writes a whole file, closed and checked. Not durable until syncAll().
void writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes);
void writeFile(const std::filesystem::path& path, std::string_view text);

/// Makes everything written so far to folder's file system durable, including names: one wait instead of a
/// journal commit for each of a store's hundred files and folders. Throws Error.
void syncAll(const std::filesystem::path& folder);
/// Makes the names in one folder durable, after a rename.
void syncFolder(const std::filesystem::path& folder);

// A folder that gets its final name only when it is complete.

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

/// The NAME of an unfinished ".NAME.importing-PID-N" or ".NAME.importing-KEY" (WorkFolder), or of an old
/// store beside it that was being replaced; nullopt for any other.
std::optional<std::string> nameOfUnfinishedFolder(const std::string& entry);

/// Where target's links lead. Throws InputError if the folder that it is in is missing.
std::filesystem::path placeOfStore(const std::filesystem::path& target);

/// Renames `from` to `to`, on one file system. With `replace` an existing `to` is removed after the rename;
/// without it InputError says that it exists. After a kill at any moment `to` is the old one or the new one,
/// or recoverFolders() makes it so.
/// @param exchanges  false: as on a file system that cannot exchange names in one step
void publishFolder(const std::filesystem::path& from, const std::filesystem::path& to, bool replace,
                   bool exchanges = true);

/// In `folder`: removes unfinished stores (".NAME.zarr.importing-PID-N") of dead processes, and of those that
/// can be continued (WorkFolder) the ones with nothing to continue. Restores the name of an old store if the
/// process that replaced it died between two renames.
void recoverFolders(const std::filesystem::path& folder);

} // namespace tessera

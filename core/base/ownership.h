// core/base/ownership.h: locks (flock) that show whether an unfinished file or folder still has its owner.
// The kernel drops a lock when the process ends, however it ends. An unlocked file with a temporary name was
// left by a dead process, and may be removed. A process number would prove nothing: numbers are reused, and
// containers that share a folder have their own.
#pragma once

#include "core/base/files.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace tessera {

enum class LockKind { shared, exclusive };
struct LockTry {
    FileHandle file; // holds the lock if locked
    bool locked = false;
    bool busy = false; // another process holds it; neither: there is nothing to lock, or no locks here
};
/// Locks the file or folder at path, without waiting. Links are not followed.
/// @param make  an empty file, mode 0600, if there is none
LockTry tryLock(const std::filesystem::path& path, LockKind kind, bool make = false);

/// True if a lock on folder's file system excludes every process that sees it: true for local disks, false
/// for file systems that other machines may share.
bool locksProve(const std::filesystem::path& folder);

/// NAME, shortened if it is so long that a name of temporary files could not hold it; an ending stays.
std::string shortenedName(const std::string& name);
/// ".NAME.WHAT-PID-N": a temporary name for NAME, shortened.
std::string temporaryName(const std::string& name, std::string_view what, int attempt);
/// The NAME of such a name; nullopt for any other. A watchdog's "-removed" (interrupt.cpp) may follow.
std::optional<std::string> nameOfTemporary(std::string_view entry, std::string_view what);

/// Makes a folder and locks it.
/// @return nullopt if the name is taken; else a handle, which holds the lock if the file system has locks.
/// Throws Error naming path.
std::optional<FileHandle> makeOwnFolder(const std::filesystem::path& path, unsigned mode);
/// The same for an empty file, open for reading and writing.
std::optional<FileHandle> makeOwnFile(const std::filesystem::path& path);

/// Calls found, while it holds the lock, for every regular file and folder in `folder` that isTemporary and
/// whose owner is provably dead. Errors are silently ignored.
void eachLeftover(const std::filesystem::path& folder,
                  const std::function<bool(const std::string& name)>& isTemporary,
                  const std::function<void(const std::filesystem::path&)>& found);
/// Removes those files and folders.
void sweepLeftovers(const std::filesystem::path& folder,
                    const std::function<bool(const std::string& name)>& isTemporary);

} // namespace tessera

// core/base/ownership.h: locks (flock) that say whether an unfinished file or folder still has its maker. The
// kernel drops a lock when the process ends, however it ends. A thing named like a temporary one and held by
// nobody was left by a dead process, and may be removed. A process number would prove nothing: numbers are
// used again, and containers that share a folder count on their own.
#pragma once

#include "core/base/file_handle.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace tessera {

enum class LockKind { shared, exclusive };
struct LockTry {
    FileHandle file; // holds the lock where locked
    bool locked = false;
    bool busy = false; // somebody else holds it; neither: there is nothing to lock, or no lock can be had
};
/// Locks what stands at path, without waiting. Links are not followed.
/// @param make  an empty file, mode 0600, where there is none
LockTry tryLock(const std::filesystem::path& path, LockKind kind, bool make = false);

/// Whether a lock on folder's file system excludes everybody who sees it: true for the machine's own disks,
/// false for what other machines may share.
bool locksProve(const std::filesystem::path& folder);

/// ".NAME.WHAT-PID-N": a name for what becomes NAME; shorter where NAME is very long.
std::string temporaryName(const std::string& name, std::string_view what, int attempt);
/// The NAME of such a name; nothing for any other. A watchdog's "-removed" (interrupt.cpp) may follow.
std::optional<std::string> nameOfTemporary(std::string_view entry, std::string_view what);

/// Makes a folder and locks it.
/// @return nothing when the name is taken; else a handle, which holds the lock where the file system has
/// locks. Throws Error naming path.
std::optional<FileHandle> makeOwnFolder(const std::filesystem::path& path, unsigned mode);
/// The same for an empty file, open for reading and writing.
std::optional<FileHandle> makeOwnFile(const std::filesystem::path& path);

/// Calls found for every regular file and folder in `folder` that isTemporary and whose owner is provably
/// dead, while it holds the lock. Says nothing and does nothing where anything is in the way.
void eachLeftover(const std::filesystem::path& folder,
                  const std::function<bool(const std::string& name)>& isTemporary,
                  const std::function<void(const std::filesystem::path&)>& found);
/// Removes these.
void sweepLeftovers(const std::filesystem::path& folder,
                    const std::function<bool(const std::string& name)>& isTemporary);

} // namespace tessera

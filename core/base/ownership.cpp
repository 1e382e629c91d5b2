// core/base/ownership.cpp: see ownership.h.
#include "core/base/ownership.h"

#include "core/base/error.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h> // flock
#include <sys/stat.h>
#include <sys/vfs.h> // statfs
#include <unistd.h>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kNameBytes = 180; // of NAME in a temporary name; file systems allow 255 in all

Error cannotMake(const fs::path& path) {
    return Error(printable(path.string()) + ": cannot be made: " + std::strerror(errno));
}

/// True if path still names the open file: before the lock a name may have been removed, or given to another
/// file.
bool isStill(const FileHandle& file, const fs::path& path) {
    struct stat open {
    }, named{};
    return ::fstat(file.descriptor(), &open) == 0 && ::lstat(path.c_str(), &named) == 0 &&
           open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

/// Locks a file or folder that was just made.
/// @return false if another process took it for a leftover and locked it first
bool own(const FileHandle& file, const fs::path& path) {
    if (file.descriptor() < 0)
        return false;
    if (::flock(file.descriptor(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return false;
    return isStill(file, path);
}

bool isNumber(std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

} // namespace

LockTry tryLock(const fs::path& path, LockKind kind, bool make) {
    constexpr int kTries = 100; // the name may get another file between opening and locking
    for (int i = 0; i < kTries; ++i) {
        LockTry result;
        const int flags = O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
        result.file = FileHandle(make ? ::open(path.c_str(), O_RDWR | O_CREAT | flags, 0600)
                                      : ::open(path.c_str(), O_RDONLY | flags));
        if (make && result.file.descriptor() < 0) // may exist in a folder where nothing can be made
            result.file = FileHandle(::open(path.c_str(), O_RDONLY | flags));
        if (result.file.descriptor() < 0)
            return {};
        const int operation = (kind == LockKind::shared ? LOCK_SH : LOCK_EX) | LOCK_NB;
        if (::flock(result.file.descriptor(), operation) != 0) {
            result.busy = errno == EWOULDBLOCK;
            return result;
        }
        if (isStill(result.file, path)) {
            result.locked = true;
            return result;
        }
    }
    return {};
}

bool locksProve(const fs::path& folder) {
    // ext2 to ext4, XFS, Btrfs, tmpfs, ramfs, overlay, F2FS, ZFS, bcachefs, FAT, exFAT, NTFS (linux/magic.h)
    constexpr std::array<unsigned long, 12> kOwn = {0xEF53,     0x58465342, 0x9123683E, 0x01021994,
                                                    0x858458F6, 0x794C7630, 0xF2F52010, 0x2FC12FC1,
                                                    0xCA451A4E, 0x4D44,     0x2011BAB0, 0x7366746E};
    struct statfs facts {};
    if (::statfs(folder.c_str(), &facts) != 0)
        return false;
    const auto type = static_cast<unsigned long>(facts.f_type) & 0xFFFFFFFFul;
    return std::find(kOwn.begin(), kOwn.end(), type) != kOwn.end();
}

std::string shortenedName(const std::string& name) {
    if (name.size() <= kNameBytes)
        return name;
    const std::string extension = fs::path(name).extension().string();
    const std::size_t tail = extension.size() < kNameBytes / 2 ? extension.size() : 0;
    return name.substr(0, kNameBytes - tail) + extension.substr(0, tail);
}

std::string temporaryName(const std::string& name, std::string_view what, int attempt) {
    return "." + shortenedName(name) + "." + std::string(what) + "-" + std::to_string(::getpid()) + "-" +
           std::to_string(attempt);
}

std::optional<std::string> nameOfTemporary(std::string_view entry, std::string_view what) {
    constexpr std::string_view kRemoved = "-removed";
    if (entry.ends_with(kRemoved))
        entry.remove_suffix(kRemoved.size());
    const std::string mark = "." + std::string(what) + "-";
    const std::size_t at = entry.rfind(mark);
    if (entry.empty() || entry.front() != '.' || at == std::string_view::npos || at < 2)
        return std::nullopt;
    const std::string_view numbers = entry.substr(at + mark.size());
    const std::size_t dash = numbers.find('-');
    if (dash == std::string_view::npos || !isNumber(numbers.substr(0, dash)) ||
        !isNumber(numbers.substr(dash + 1)))
        return std::nullopt;
    return std::string(entry.substr(1, at - 1));
}

std::optional<FileHandle> makeOwnFolder(const fs::path& path, unsigned mode) {
    if (::mkdir(path.c_str(), mode) != 0) {
        if (errno == EEXIST)
            return std::nullopt;
        throw cannotMake(path);
    }
    FileHandle folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW));
    return own(folder, path) ? std::optional<FileHandle>(std::move(folder)) : std::nullopt;
}

std::optional<FileHandle> makeOwnFile(const fs::path& path) {
    FileHandle file(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666));
    if (file.descriptor() < 0) {
        if (errno == EEXIST)
            return std::nullopt;
        throw cannotMake(path);
    }
    return own(file, path) ? std::optional<FileHandle>(std::move(file)) : std::nullopt;
}

void eachLeftover(const fs::path& folder, const std::function<bool(const std::string&)>& isTemporary,
                  const std::function<void(const fs::path&)>& found) {
    if (!locksProve(folder))
        return;
    std::vector<fs::path> entries; // listed before any change
    std::error_code ignored;
    for (fs::directory_iterator entry(folder, ignored), end; !ignored && entry != end;
         entry.increment(ignored))
        if (isTemporary(entry->path().filename().string()))
            entries.push_back(entry->path());
    for (const fs::path& entry : entries) {
        const fs::file_type type = fs::symlink_status(entry, ignored).type();
        if (type != fs::file_type::regular && type != fs::file_type::directory)
            continue;
        if (const LockTry lock = tryLock(entry, LockKind::exclusive); lock.locked)
            found(entry);
    }
}

void sweepLeftovers(const fs::path& folder, const std::function<bool(const std::string&)>& isTemporary) {
    eachLeftover(folder, isTemporary, [](const fs::path& entry) {
        std::error_code ignored;
        fs::remove_all(entry, ignored);
    });
}

} // namespace tessera

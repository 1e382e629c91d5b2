// core/base/output_file.cpp: see output_file.h.
#include "core/base/output_file.h"

#include "core/base/error.h"
#include "core/base/ownership.h"
#include "core/base/shown_text.h"

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fcntl.h> // AT_FDCWD
#include <iostream>
#include <mutex>
#include <string>
#include <sys/stat.h>
#include <unistd.h>

namespace tessera {
namespace {

namespace fs = std::filesystem;
constexpr std::string_view kMark = "tessera"; // in the names of unfinished files

Error cannotWrite(const std::string& shown, int error) {
    return Error(printable(shown) + ": cannot be written: " + std::strerror(error));
}

std::string kindOf(mode_t mode) {
    if (S_ISDIR(mode))
        return "a folder";
    if (S_ISCHR(mode) || S_ISBLK(mode))
        return "a device";
    return S_ISFIFO(mode) ? "a pipe" : "a socket";
}

BadFile isThere(const fs::path& path, const std::string& found) {
    return badFile(path.string(), "a new name, or --force to replace", found);
}

fs::path folderOf(const fs::path& target) {
    return target.has_parent_path() ? target.parent_path() : fs::path(".");
}

/// Removes what dead processes left in a folder. One of very many files, such as that of a picture's tiles,
/// is read through at most once in a while: else writing them all would take their square.
void sweepNowAndThen(const fs::path& folder) {
    using Clock = std::chrono::steady_clock;
    constexpr std::size_t kVeryMany = 64;
    constexpr std::chrono::seconds kWhile{10};
    struct Swept {
        fs::path folder;
        Clock::time_point at;
    };
    static std::mutex mutex;
    static Swept last; // of very many files
    {
        const std::lock_guard lock(mutex);
        if (last.folder == folder && Clock::now() - last.at < kWhile)
            return;
    }
    std::size_t files = 0;
    sweepLeftovers(folder, [&](const std::string& name) {
        ++files;
        return nameOfTemporary(name, kMark).has_value();
    });
    if (files < kVeryMany)
        return;
    const std::lock_guard lock(mutex);
    last = {folder, Clock::now()};
}

} // namespace

fs::path outputTarget(const fs::path& path) {
    constexpr int kLinks = 40; // as many as Linux follows
    fs::path target = path;
    std::error_code error;
    for (int i = 0; fs::is_symlink(target, error); ++i) {
        const fs::path to = i < kLinks ? fs::read_symlink(target, error) : fs::path();
        if (to.empty())
            throw badFile(path.string(), "a file to write", "links that lead nowhere");
        target = target.parent_path() / to; // an absolute one replaces the folder
    }
    return target;
}

void checkOutputFile(const fs::path& path, Existing existing) {
    const fs::path target = outputTarget(path), folder = folderOf(target);
    struct stat facts {};
    if (::stat(target.c_str(), &facts) == 0) {
        if (!S_ISREG(facts.st_mode))
            throw badFile(path.string(), "a file to write", kindOf(facts.st_mode));
        if (existing == Existing::isKept)
            throw isThere(path, "a file of that name");
        if (::access(target.c_str(), W_OK) != 0)
            throw badFile(path.string(), "a file that may be replaced", std::strerror(errno));
    }
    if (::stat(folder.c_str(), &facts) != 0 || !S_ISDIR(facts.st_mode))
        throw badFile(path.string(), "an existing folder to write in", "none");
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        throw badFile(path.string(), "a folder that may be written in", std::strerror(errno));
}

std::optional<std::string> nameOfUnfinishedFile(std::string_view entry) {
    return nameOfTemporary(entry, kMark);
}

bool renameToNewFile(const fs::path& from, const fs::path& to, bool inOneStep) {
    if (inOneStep) {
        if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0)
            return true;
        if (errno == EEXIST)
            return false;
        if (errno != EINVAL && errno != ENOSYS && errno != ENOTSUP)
            throw cannotWrite(to.string(), errno);
    }
    if (::link(from.c_str(), to.c_str()) == 0) {
        ::unlink(from.c_str());
        return true;
    }
    if (errno == EEXIST)
        return false;
    // No links either (FAT, some network file systems): a file may appear between the two calls.
    struct stat ignored {};
    if (::lstat(to.c_str(), &ignored) == 0)
        return false;
    if (::rename(from.c_str(), to.c_str()) != 0)
        throw cannotWrite(to.string(), errno);
    return true;
}

OutputFile::OutputFile(const fs::path& path, Existing existing)
    : shown_(path), target_(outputTarget(path)), existing_(existing) {
    checkOutputFile(path, existing);
    const fs::path folder = folderOf(target_);
    sweepNowAndThen(folder);
    std::optional<FileHandle> made;
    constexpr int kTries = 1000;
    for (int attempt = 0; !made; ++attempt) {
        if (attempt == kTries)
            throw cannotWrite(shown_.string(), EEXIST);
        path_ = folder / temporaryName(target_.filename().string(), kMark, attempt);
        made = makeOwnFile(path_);
    }
    file_ = std::move(*made);
    unfinished_.emplace(path_);
}

OutputFile::~OutputFile() {
    std::error_code ignored;
    if (!renamed_)
        fs::remove(path_, ignored);
}

void OutputFile::writeAt(std::uint64_t offset, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t put =
            ::pwrite(file_.descriptor(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (put < 0 && errno == EINTR)
            continue;
        if (put <= 0)
            throw cannotWrite(shown_.string(), put == 0 ? ENOSPC : errno);
        offset += static_cast<std::uint64_t>(put);
        bytes = bytes.subspan(static_cast<std::size_t>(put));
    }
}

void OutputFile::finish() {
    struct stat before {};
    if (::stat(target_.c_str(), &before) == 0)
        static_cast<void>(::fchmod(file_.descriptor(), before.st_mode & 0777)); // a failure is ignored
    // Some file systems do not support it (EINVAL).
    if (::fsync(file_.descriptor()) != 0 && errno != EINVAL && errno != ENOTSUP)
        throw cannotWrite(shown_.string(), errno);
    // A second descriptor is closed first and checked: the lock stays until the file has its name.
    FileHandle(::dup(file_.descriptor())).close(shown_.string());
    if (existing_ == Existing::isKept) {
        if (!renameToNewFile(path_, target_))
            throw isThere(shown_, "something that was written there meanwhile");
    } else if (::rename(path_.c_str(), target_.c_str()) != 0) {
        throw cannotWrite(shown_.string(), errno);
    }
    renamed_ = true;
    unfinished_->forget();
    file_ = FileHandle();
}

void writeOutputFile(const fs::path& path, std::string_view text) {
    OutputFile file(path);
    file.writeAt(0, std::as_bytes(std::span(text)));
    file.finish();
}

void finishStandardOutput() {
    errno = 0;
    const bool streamed = std::cout.flush().good(); // output of the option parser
    const bool failed = std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
    if (!streamed || failed)
        throw cannotWrite("standard output", errno ? errno : EIO);
    // Closing reports failed writes on some file systems. A descriptor that was not open is no failure.
    if (const int copy = ::dup(STDOUT_FILENO); copy >= 0)
        FileHandle(copy).close("standard output");
}

} // namespace tessera

// bricking/store/store_files.cpp: see store_files.h.
#include "bricking/store/store_files.h"

#include "bricking/store/folder_below.h"
#include "bricking/store/work_folder.h"
#include "core/base/error.h"
#include "core/base/output_file.h" // outputTarget
#include "core/base/ownership.h"
#include "core/base/shown_text.h"

#include <cerrno>
#include <cstdio> // renameat2
#include <cstring>
#include <fcntl.h> // AT_FDCWD
#include <string>
#include <sys/stat.h>
#include <unistd.h>

namespace tessera {
namespace {

std::string reason() {
    return std::strerror(errno);
}

Error writeFailed(const std::filesystem::path& path, const char* what) {
    return Error(path.string() + ": could not " + what + ": " + reason());
}

} // namespace

StoreFolder openFolder(const std::filesystem::path& path) {
    if (auto place = remotePlaceOf(path))
        return {.disk = {}, .remote = std::move(place)};
    FileHandle folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (folder.descriptor() < 0)
        throw badFile(path.string(), "a folder that can be opened", reason());
    return {.disk = std::move(folder), .remote = {}};
}

namespace {

/// Opens what lies below a folder, name by name, without following links; nullopt: something is missing.
/// @param flags  for the last name
std::optional<FileHandle> openBelow(const StoreFolder& folder, std::string_view relative, int flags,
                                    const char* expected, const std::filesystem::path& shown) {
    FileHandle at;
    int parent = folder.disk.descriptor();
    std::string_view rest = relative;
    while (true) {
        const std::size_t slash = rest.find('/');
        const std::string name(rest.substr(0, slash));
        const bool last = slash == std::string_view::npos;
        TESSERA_CHECK(!name.empty() && name != "." && name != "..");
        FileHandle next(
            ::openat(parent, name.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | (last ? flags : O_DIRECTORY)));
        if (next.descriptor() < 0) {
            if (errno == ENOENT)
                return std::nullopt;
            struct stat facts {};
            const int why = errno; // of a link to a folder it is ENOTDIR
            const bool isLink =
                why == ELOOP ||
                (::fstatat(parent, name.c_str(), &facts, AT_SYMLINK_NOFOLLOW) == 0 && S_ISLNK(facts.st_mode));
            throw badFile((shown / relative).string(), expected,
                          isLink ? "a symbolic link" : std::strerror(why));
        }
        at = std::move(next);
        if (last)
            return at;
        parent = at.descriptor();
        rest.remove_prefix(slash + 1);
    }
}

} // namespace

std::optional<StoreFolder> openFolderIn(const StoreFolder& folder, std::string_view relative,
                                        const std::filesystem::path& shown) {
    if (folder.remote)
        return StoreFolder{
            .disk = {},
            .remote = RemotePlace{folder.remote->files, folder.remote->nameOf(std::string(relative))}};
    std::optional<FileHandle> found = openBelow(folder, relative, O_DIRECTORY, "a folder", shown);
    if (!found)
        return std::nullopt;
    return StoreFolder{.disk = *std::move(found), .remote = {}};
}

std::optional<StoreFile> openIn(const StoreFolder& folder, std::string_view relative,
                                const std::filesystem::path& shown) {
    if (folder.remote) {
        std::string whole = folder.remote->nameOf(std::string(relative));
        if (!folder.remote->files->sizeOf(whole))
            return std::nullopt;
        return StoreFile{.disk = {}, .remote = folder.remote->files, .name = std::move(whole)};
    }
    // O_NONBLOCK: opening a FIFO must not wait for its writer.
    std::optional<FileHandle> at =
        openBelow(folder, relative, O_NONBLOCK, "a regular file in regular folders", shown);
    if (!at)
        return std::nullopt;
    struct stat facts {};
    if (::fstat(at->descriptor(), &facts) != 0 || !S_ISREG(facts.st_mode))
        throw badFile((shown / relative).string(), "a regular file", "something else");
    return StoreFile{.disk = *std::move(at), .remote = {}};
}

std::uint64_t fileSize(const StoreFile& file, const std::string& shown) {
    if (file.remote)
        return file.remote->sizeOf(file.name).value_or(0);
    struct stat facts {};
    if (::fstat(file.disk.descriptor(), &facts) != 0)
        throw badFile(shown, "a readable file", reason());
    return static_cast<std::uint64_t>(facts.st_size);
}

void readAt(const StoreFile& file, std::uint64_t offset, std::span<std::byte> out, const std::string& shown) {
    if (file.remote)
        return file.remote->readAt(file.name, offset, out);
    while (!out.empty()) {
        const ssize_t got =
            ::pread(file.disk.descriptor(), out.data(), out.size(), static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            throw badFile(shown, "a readable file", reason());
        if (got == 0)
            throw badFile(shown,
                          std::to_string(out.size()) + " more bytes at offset " + std::to_string(offset),
                          "the end of the file");
        offset += static_cast<std::uint64_t>(got);
        out = out.subspan(static_cast<std::size_t>(got));
    }
}

std::optional<std::string> readText(const StoreFolder& folder, std::string_view relative,
                                    const std::filesystem::path& shown, std::uint64_t limitBytes) {
    const std::optional<StoreFile> file = openIn(folder, relative, shown);
    if (!file)
        return std::nullopt;
    const std::string name = (shown / relative).string();
    const std::uint64_t size = fileSize(*file, name);
    if (size > limitBytes)
        throw badFile(name, "at most " + std::to_string(limitBytes) + " bytes", std::to_string(size));
    std::string text(static_cast<std::size_t>(size), '\0');
    readAt(*file, 0, std::as_writable_bytes(std::span(text)), name);
    return text;
}

FileHandle openForWriting(const std::filesystem::path& path) {
    FileHandle file(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666));
    if (file.descriptor() < 0)
        throw writeFailed(path, "write");
    return file;
}

void writeAt(const FileHandle& file, std::uint64_t offset, std::span<const std::byte> bytes,
             const std::filesystem::path& shown) {
    while (!bytes.empty()) {
        const ssize_t put =
            ::pwrite(file.descriptor(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (put < 0 && errno == EINTR)
            continue;
        if (put <= 0)
            throw writeFailed(shown, "write");
        offset += static_cast<std::uint64_t>(put);
        bytes = bytes.subspan(static_cast<std::size_t>(put));
    }
}

void writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes) {
    FileHandle file = openForWriting(path);
    writeAt(file, 0, bytes, path);
    file.close(path.string());
}

void writeFile(const std::filesystem::path& path, std::string_view text) {
    writeFile(path, std::as_bytes(std::span(text)));
}

void syncAll(const std::filesystem::path& folder) {
    if (::syncfs(openFolder(folder).disk.descriptor()) != 0)
        throw writeFailed(folder, "make durable");
}

void syncFolder(const std::filesystem::path& folder) {
    // Some file systems refuse fsync on folders (EINVAL); they order names by themselves.
    if (::fsync(openFolder(folder).disk.descriptor()) != 0 && errno != EINVAL)
        throw writeFailed(folder, "make durable");
}

namespace {

namespace fs = std::filesystem;
constexpr std::string_view kMark = "importing";
constexpr std::string_view kOld = ".old"; // behind the temporary name: the store that is being replaced

Error cannotRename(const fs::path& target) {
    return Error(printable(target.string()) +
                 ": could not rename the finished store: " + std::strerror(errno));
}

/// A file system, or a kernel, without this kind of rename.
bool isUnknown(int error) {
    return error == EINVAL || error == ENOSYS || error == ENOTSUP;
}

/// A plain rename() of a folder replaces an empty folder at most, never a store.
bool renameToNewName(const fs::path& from, const fs::path& to) {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0)
        return true;
    if (isUnknown(errno) && ::rename(from.c_str(), to.c_str()) == 0)
        return true;
    if (errno != EEXIST && errno != ENOTEMPTY && errno != ENOTDIR)
        throw cannotRename(to);
    return false;
}

/// A name for the store that is being replaced, beside the new one.
fs::path nameForOld(const fs::path& to) {
    std::error_code ignored;
    for (int attempt = 0;; ++attempt) {
        fs::path old = to.parent_path() / temporaryName(to.filename().string(), kMark, attempt);
        old += kOld;
        if (!fs::exists(fs::symlink_status(old, ignored)))
            return old;
    }
}

/// Two renames; between them the name is missing, and recoverFolders() knows what to do.
void replaceInTwoSteps(const fs::path& from, const fs::path& to) {
    const fs::path old = nameForOld(to);
    // Locked: recovery leaves it alone while this process lives.
    const LockTry held = tryLock(to, LockKind::exclusive);
    if (::rename(to.c_str(), old.c_str()) != 0)
        throw cannotRename(to);
    if (::rename(from.c_str(), to.c_str()) != 0) {
        const Error problem = cannotRename(to);
        if (::rename(old.c_str(), to.c_str()) != 0)
            throw Error(std::string(problem.what()) + "; the old store is now " + printable(old.string()));
        throw problem;
    }
    std::error_code ignored;
    fs::remove_all(old, ignored);
}

bool isOld(const std::string& name) {
    return name.ends_with(kOld) &&
           nameOfTemporary(std::string_view(name).substr(0, name.size() - kOld.size()), kMark);
}

} // namespace

std::optional<std::string> nameOfUnfinishedFolder(const std::string& entry) {
    if (std::optional<std::string> name = WorkFolder::nameOf(entry))
        return name;
    return nameOfTemporary(isOld(entry) ? entry.substr(0, entry.size() - kOld.size()) : entry, kMark);
}

void publishFolder(const fs::path& from, const fs::path& to, bool replace, bool exchanges) {
    constexpr int kTries = 100; // other processes may create and remove the name meanwhile
    for (int i = 0; i < kTries; ++i) {
        if (renameToNewName(from, to))
            return;
        if (!replace)
            throw badFile(to.string(), "a new name, or --force to replace",
                          "something that was written there meanwhile");
        if (!exchanges)
            return replaceInTwoSteps(from, to);
        if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_EXCHANGE) == 0) {
            std::error_code ignored;
            fs::remove_all(from, ignored); // the old one, which has the temporary name
            return;
        }
        if (isUnknown(errno))
            return replaceInTwoSteps(from, to);
        if (errno != ENOENT)
            throw cannotRename(to);
    }
    throw cannotRename(to);
}

void recoverFolders(const fs::path& folder) {
    const auto isStoreName = [](const std::optional<std::string>& name) {
        return name && name->ends_with(".zarr");
    };
    eachLeftover(folder, isOld, [&](const fs::path& old) {
        const std::string name = old.filename().string();
        const auto store = nameOfTemporary(name.substr(0, name.size() - kOld.size()), kMark);
        if (isStoreName(store) && !renameToNewName(old, folder / *store)) {
            std::error_code ignored;
            fs::remove_all(old, ignored); // the new one has the name
        }
    });
    sweepLeftovers(folder,
                   [&](const std::string& name) { return isStoreName(nameOfTemporary(name, kMark)); });
    WorkFolder::sweepEmpty(folder);
}

fs::path placeOfStore(const fs::path& target) {
    fs::path plain = fs::absolute(target).lexically_normal();
    if (plain.filename().empty())
        plain = plain.parent_path(); // "x.zarr/" means x.zarr
    fs::path place = outputTarget(plain);
    std::error_code ignored;
    if (!fs::is_directory(place.parent_path(), ignored))
        throw badFile(place.parent_path().string(), "a folder to write into", "none");
    return place;
}

TemporaryFolder::TemporaryFolder(const fs::path& target) : target_(placeOfStore(target)) {
    const fs::path parent = target_.parent_path();
    recoverFolders(parent);
    WorkFolder::sweepOf(target_, {});
    constexpr int kTries = 1000;
    for (int attempt = 0; attempt < kTries; ++attempt) {
        path_ = parent / temporaryName(target_.filename().string(), kMark, attempt);
        if (auto made = makeOwnFolder(path_, 0777)) {
            owned_ = std::move(*made);
            unfinished_.emplace(path_);
            return;
        }
    }
    throw Error(printable(path_.string()) + ": could not make the folder: " + std::strerror(EEXIST));
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    if (!committed_)
        fs::remove_all(path_, ignored);
}

void TemporaryFolder::commit(bool durable, bool replace) {
    if (durable)
        syncAll(path_); // before the rename: a crash must not leave the name without the data
    // Until here a watchdog may remove the folder; from here on it may be the old store, or have the name.
    unfinished_.reset();
    publishFolder(path_, target_, replace);
    committed_ = true;
    if (durable)
        syncFolder(target_.parent_path());
}

} // namespace tessera

// bricking/store/temporary_folder.cpp: see temporary_folder.h.
#include "bricking/store/temporary_folder.h"

#include "bricking/store/file_io.h"
#include "core/base/error.h"
#include "core/base/output_file.h" // outputTarget
#include "core/base/ownership.h"
#include "core/base/shown_text.h"

#include <cerrno>
#include <cstdio> // renameat2
#include <cstring>
#include <fcntl.h> // AT_FDCWD
#include <string>

namespace tessera {
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

/// Two renames; between them the name is missing, and recoverFolders() knows what to do.
void replaceInTwoSteps(const fs::path& from, const fs::path& to) {
    fs::path old = from;
    old += kOld;
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
}

TemporaryFolder::TemporaryFolder(const fs::path& target) {
    fs::path plain = fs::absolute(target).lexically_normal();
    if (plain.filename().empty())
        plain = plain.parent_path(); // "x.zarr/" means x.zarr
    target_ = outputTarget(plain);
    std::error_code ignored;
    const fs::path parent = target_.parent_path();
    if (!fs::is_directory(parent, ignored))
        throw badFile(parent.string(), "a folder to write into", "none");
    recoverFolders(parent);
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

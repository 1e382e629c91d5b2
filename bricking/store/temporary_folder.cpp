// bricking/store/temporary_folder.cpp: see temporary_folder.h.
#include "bricking/store/temporary_folder.h"

#include "bricking/store/file_io.h"
#include "core/error.h"

#include <cerrno>
#include <cstdio> // renameat2
#include <cstring>
#include <fcntl.h> // AT_FDCWD
#include <string>
#include <sys/stat.h>
#include <unistd.h>

namespace tessera {
namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder(const fs::path& target) {
    fs::path plain = fs::absolute(target).lexically_normal();
    if (plain.filename().empty())
        plain = plain.parent_path(); // "x.zarr/" means x.zarr
    target_ = plain;
    std::error_code ignored;
    if (!fs::is_directory(target_.parent_path(), ignored))
        throw badFile(target_.parent_path().string(), "a folder to write into", "none");
    for (int attempt = 0;; ++attempt) {
        std::string name = ".";
        name += target_.filename().string();
        name += ".importing-" + std::to_string(::getpid());
        name += "-" + std::to_string(attempt);
        path_ = target_.parent_path() / name;
        if (::mkdir(path_.c_str(), 0777) == 0) {
            unfinished_.emplace(path_);
            return;
        }
        if (errno != EEXIST || attempt == 1000)
            throw Error(path_.string() + ": could not make the folder: " + std::strerror(errno));
    }
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    if (!committed_)
        fs::remove_all(path_, ignored);
}

void TemporaryFolder::commit(bool durable) {
    if (durable)
        syncAll(path_);  // before the rename: a crash must not leave the name without the data
    unfinished_.reset(); // from here on the name may be the old store's
    const fs::path parent = target_.parent_path();
    const auto failed = [&] {
        return Error(target_.string() + ": could not rename the finished store: " + std::strerror(errno));
    };
    if (fs::symlink_status(target_).type() == fs::file_type::not_found) {
        if (::rename(path_.c_str(), target_.c_str()) != 0)
            throw failed();
        committed_ = true;
    } else if (::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0) {
        committed_ = true; // the old store now has the temporary name
        if (durable)
            syncFolder(parent);
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    } else {
        // No exchange on this file system: the name is missing for a moment, but never half a store.
        const fs::path old = path_.string() + ".old";
        if (::rename(target_.c_str(), old.c_str()) != 0)
            throw failed();
        if (::rename(path_.c_str(), target_.c_str()) != 0) {
            const Error problem = failed();
            if (::rename(old.c_str(), target_.c_str()) != 0)
                throw Error(std::string(problem.what()) + "; the old store is now " + old.string());
            throw problem;
        }
        committed_ = true;
        std::error_code ignored;
        fs::remove_all(old, ignored);
    }
    if (durable)
        syncFolder(parent);
}

} // namespace tessera

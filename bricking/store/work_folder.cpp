// bricking/store/work_folder.cpp: see work_folder.h. A folder gets its name when it has a "store" in it, and
// loses "store" in the step that gives the store its name. So one without "store" has nothing to go on with.
// Where an old store is replaced, that step is an exchange: "store" is the old one then, which the number of
// its inode shows. "publishing" has the number of the new one.
#include "bricking/store/work_folder.h"

#include "bricking/store/store_files.h"
#include "core/base/error.h"
#include "core/base/ownership.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string_view>
#include <sys/file.h> // flock
#include <sys/stat.h>
#include <system_error>
#include <thread>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kImporting = "importing"; // as of TemporaryFolder
constexpr std::string_view kMaking = "making";
constexpr std::string_view kPart = "part-";
constexpr const char* kPublishing = "publishing";
constexpr std::size_t kKeyDigits = 32;
constexpr int kMostTries = 100;
constexpr std::chrono::milliseconds kForOthers{20}; // who make, lock or remove it

Error cannotMakeFolder(const fs::path& path) {
    return Error(printable(path.string()) + ": could not make the folder: " + std::strerror(errno));
}

fs::path workPath(const fs::path& place, const std::string& key) {
    return place.parent_path() /
           ("." + shortenedName(place.filename().string()) + "." + std::string(kImporting) + "-" + key);
}

bool isThere(const fs::path& path) {
    std::error_code ignored;
    return fs::exists(path, ignored);
}

void removeAll(const fs::path& path) {
    std::error_code ignored;
    fs::remove_all(path, ignored);
}

/// True if a work folder has the store that is made in it, not the one that this has replaced.
bool hasStore(const fs::path& work) {
    struct stat store {};
    if (::stat((work / "store").c_str(), &store) != 0)
        return false;
    std::uint64_t number = 0;
    std::ifstream note(work / kPublishing);
    return !(note >> number) || number == static_cast<std::uint64_t>(store.st_ino);
}

void noteStore(const fs::path& work) {
    struct stat store {};
    if (::stat((work / "store").c_str(), &store) != 0)
        throw cannotMakeFolder(work / "store");
    writeFile(work / kPublishing, std::to_string(static_cast<std::uint64_t>(store.st_ino)) + "\n");
}

/// True for a name of an entry of the folder.
template <typename Is> bool hasEntry(const fs::path& folder, const Is& is) {
    std::error_code failed;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
        if (is(entry->path().filename().string()))
            return true;
    return false;
}

bool hasPart(const fs::path& work) {
    return hasStore(work) && hasEntry(work, [](const std::string& name) { return name.starts_with(kPart); });
}

} // namespace

std::string WorkFolder::nameOfPart(int number) {
    char name[32];
    std::snprintf(name, sizeof name, "part-%04d", number);
    return name;
}

std::optional<std::string> WorkFolder::nameOf(const std::string& entry) {
    const std::string mark = "." + std::string(kImporting) + "-";
    const std::size_t at = entry.rfind(mark);
    if (entry.empty() || entry.front() != '.' || at == std::string::npos || at < 2)
        return std::nullopt;
    const std::string_view key = std::string_view(entry).substr(at + mark.size());
    if (key.size() != kKeyDigits || key.find_first_not_of("0123456789abcdef") != std::string_view::npos)
        return std::nullopt;
    return entry.substr(1, at - 1);
}

WorkFolder::WorkFolder(const fs::path& target, const Use& use) : target_(placeOfStore(target)), use_(use) {
    recoverFolders(target_.parent_path());
    sweepOf(target_, use_.key);
    TESSERA_CHECK(use_.key.empty() || use_.key.size() == kKeyDigits);
    path_ = workPath(target_, use_.key);
    for (int attempt = 0; attempt < kMostTries; ++attempt) {
        const fs::path own =
            target_.parent_path() / temporaryName(target_.filename().string(), kImporting, attempt);
        if (use_.key.empty() ? make(own) : isThere(path_) ? open() : make(own)) {
            claims_.emplace(isLocked_ ? Claims(path_) : Claims(path_, ClaimKind::lease));
            return;
        }
        if (attempt > kMostTries / 2)
            std::this_thread::sleep_for(kForOthers);
    }
    if (use_.shared)
        throw badFile(target.string(), "a folder that several processes can work in",
                      printable(path_.string()) + ", in which one works by itself");
    if (!use_.key.empty() && isThere(path_))
        throw badFile(target.string(), "one process that imports this source to it, or --share for each",
                      "another one at work");
    throw cannotMakeFolder(path_);
}

/// Makes the folder under a temporary name, and renames it if it has a key.
/// @return false: another process was quicker
bool WorkFolder::make(const fs::path& own) {
    auto made = makeOwnFolder(own, 0777);
    if (!made)
        return false;
    held_ = std::move(*made);
    fs::create_directory(own / "store");
    if (use_.key.empty()) {
        path_ = own;
        unfinished_.emplace(path_);
    } else if (std::rename(own.c_str(), path_.c_str()) != 0) {
        const int why = errno;
        removeAll(own);
        errno = why;
        if (errno != EEXIST && errno != ENOTEMPTY)
            throw cannotMakeFolder(path_);
        return false;
    }
    const auto lock = [&] {
        return ::flock(held_.descriptor(), (use_.shared ? LOCK_SH : LOCK_EX) | LOCK_NB) == 0;
    };
    // An exclusive lock becomes a shared one through none: who looks for leftovers may have it for a moment.
    for (int attempt = 0; !(isLocked_ = lock()) && errno == EWOULDBLOCK && attempt < kMostTries; ++attempt)
        std::this_thread::sleep_for(kForOthers);
    return true;
}

/// Opens a folder that is there.
/// @return false: it went, or another process has it for a moment
bool WorkFolder::open() {
    LockTry lock = tryLock(path_, use_.shared ? LockKind::shared : LockKind::exclusive);
    if (lock.busy || !isThere(path_))
        return false;
    held_ = std::move(lock.file);
    isLocked_ = lock.locked;
    if (hasStore(path_))
        return true;
    if (use_.shared && !isAlone()) // whoever gave the store its name is about to remove it
        return true;
    removeAll(path_);
    return false;
}

bool WorkFolder::isAlone() {
    if (isLocked_)
        return ::flock(held_.descriptor(), LOCK_EX | LOCK_NB) == 0;
    return !use_.shared ||
           !hasEntry(path_, [](const std::string& name) { return Claims::nameOf(name).has_value(); });
}

WorkFolder::~WorkFolder() {
    if (isPublished_)
        return;
    const bool isKept = !use_.key.empty() && !isDiscarded_ && hasPart(path_);
    if (!isKept && (use_.key.empty() || isAlone()))
        removeAll(path_);
}

bool WorkFolder::isFinished() const {
    return !hasStore(path_);
}

void WorkFolder::makePart(int number, const std::function<void(const fs::path&)>& make) {
    const auto isUnfinished = [](const std::string& name) {
        return nameOfTemporary(name, kMaking).has_value();
    };
    sweepLeftovers(path_, isUnfinished);
    fs::path own;
    std::optional<FileHandle> held;
    for (int attempt = 0; !held; ++attempt) {
        own = path_ / temporaryName(nameOfPart(number), kMaking, attempt);
        held = makeOwnFolder(own, 0777);
        if (!held && attempt == kMostTries)
            throw cannotMakeFolder(own);
    }
    TemporaryPath unfinished(own);
    try {
        make(own);
    } catch (...) {
        removeAll(own);
        throw;
    }
    unfinished.forget();
    if (std::rename(own.c_str(), part(number).c_str()) == 0)
        return;
    const int why = errno;
    removeAll(own);
    errno = why;
    if (errno != EEXIST && errno != ENOTEMPTY) // else another process took this one for dead, and made it
        throw Error(printable(part(number).string()) +
                    ": could not rename the finished part: " + std::strerror(errno));
}

void WorkFolder::publish(bool durable, bool replace) {
    if (replace)
        noteStore(path_);
    if (durable)
        syncAll(path_); // before the rename: a crash must not leave the name without the data
    unfinished_.reset();
    publishFolder(store(), target_, replace);
    isPublished_ = true;
    if (durable)
        syncFolder(target_.parent_path());
    removeAll(path_);
}

int WorkFolder::partsOf(const fs::path& target, const std::string& key) {
    const fs::path work = workPath(placeOfStore(target), key);
    int parts = 0;
    if (hasPart(work))
        hasEntry(work, [&](const std::string& name) {
            parts += name.starts_with(kPart);
            return false;
        });
    return parts;
}

void WorkFolder::sweepEmpty(const fs::path& folder) {
    const auto isWork = [](const std::string& name) {
        const std::optional<std::string> store = nameOf(name);
        return store && store->ends_with(".zarr");
    };
    eachLeftover(folder, isWork, [](const fs::path& work) {
        if (!hasPart(work))
            removeAll(work);
    });
}

void WorkFolder::sweepOf(const fs::path& target, const std::string& key) {
    const std::string name = shortenedName(target.filename().string());
    const std::string kept = workPath(target, key).filename().string();
    sweepLeftovers(target.parent_path(),
                   [&](const std::string& entry) { return nameOf(entry) == name && entry != kept; });
}

} // namespace tessera

// core/base/claims.cpp: see claims.h.
#include "core/base/claims.h"

#include "core/base/ownership.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <fcntl.h>
#include <mutex>
#include <sys/stat.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kClaimEnd = ".claim";
/// Lock files are renewed during the work, which may take longer than this. A process that is stopped for so
/// long (a suspended laptop) may lose its lock file, and its piece is made twice.
constexpr double kLeaseSeconds = 60;

/// The file system's own time: other machines' clocks differ.
double secondsBetween(const struct stat& then, const struct stat& now) {
    return static_cast<double>(now.st_mtim.tv_sec - then.st_mtim.tv_sec) +
           1e-9 * static_cast<double>(now.st_mtim.tv_nsec - then.st_mtim.tv_nsec);
}

} // namespace

/// Renews the time of a lock file, on a thread of its own.
struct Claim::Renewal {
    Renewal(const fs::path& claim, double seconds)
        : path(claim), thread([this, seconds] {
              std::unique_lock lock(mutex);
              while (!stop.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return ended; }))
                  static_cast<void>(::utimensat(AT_FDCWD, path.c_str(), nullptr, 0));
          }) {}
    ~Renewal() {
        {
            const std::lock_guard lock(mutex);
            ended = true;
        }
        stop.notify_all();
        thread.join();
    }
    fs::path path;
    std::mutex mutex;
    std::condition_variable stop;
    bool ended = false;
    std::thread thread; // last
};

Claim::Claim(fs::path path, FileHandle file, double renewSeconds)
    : path_(std::move(path)), file_(std::move(file)) {
    if (renewSeconds > 0)
        renewal_ = std::make_unique<Renewal>(path_, renewSeconds);
}

bool Claim::isHeld() const {
    struct stat own {
    }, named{};
    return ::fstat(file_.descriptor(), &own) == 0 && ::lstat(path_.c_str(), &named) == 0 &&
           own.st_dev == named.st_dev && own.st_ino == named.st_ino;
}

/// Removes the name before releasing the lock, so that a process that opened the file meanwhile sees its
/// removal (tryLock()).
Claim::~Claim() {
    renewal_.reset();
    std::error_code ignored;
    if (isHeld())
        fs::remove(path_, ignored);
}

Claims::Claims(fs::path folder) : Claims(folder, locksProve(folder) ? ClaimKind::lock : ClaimKind::lease) {}
Claims::Claims(fs::path folder, ClaimKind kind, double leaseSeconds)
    : folder_(std::move(folder)), kind_(kind),
      leaseSeconds_(leaseSeconds > 0 ? leaseSeconds : kLeaseSeconds) {}

std::optional<std::string> Claims::nameOf(std::string_view entry) {
    if (entry.size() < kClaimEnd.size() + 2 || entry.front() != '.' || !entry.ends_with(kClaimEnd))
        return std::nullopt;
    return std::string(entry.substr(1, entry.size() - 1 - kClaimEnd.size()));
}

fs::path Claims::pathOf(const std::string& name) const {
    return folder_ / ("." + name + std::string(kClaimEnd));
}

bool Claims::isTaken(const std::string& name) const {
    std::error_code ignored;
    return fs::exists(pathOf(name), ignored);
}

/// No descriptor: another process has it.
FileHandle Claims::takeLease(const fs::path& path) const {
    const auto make = [&] {
        return FileHandle(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    };
    FileHandle made = make();
    if (made.descriptor() >= 0)
        return made;
    // Another process's lock file, which is taken over if it was not renewed. A new file gives the file
    // system's time.
    static std::atomic<int> names{0}; // within this process
    const int number = names++;
    const fs::path clock = folder_ / temporaryName("clock", "tessera", number);
    struct stat theirs {
    }, now{};
    const bool timed =
        FileHandle(::open(clock.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600)).descriptor() >= 0 &&
        ::utimensat(AT_FDCWD, clock.c_str(), nullptr, 0) == 0 && ::stat(clock.c_str(), &now) == 0;
    std::error_code ignored;
    fs::remove(clock, ignored);
    if (!timed || ::stat(path.c_str(), &theirs) != 0 || secondsBetween(theirs, now) < leaseSeconds_)
        return {};
    // One process gets the file that was stale; what another one has made meanwhile goes back.
    const fs::path own = folder_ / temporaryName("stale", "tessera", number);
    struct stat taken {};
    if (::rename(path.c_str(), own.c_str()) != 0 || ::stat(own.c_str(), &taken) != 0)
        return {};
    const bool isTheirs = taken.st_ino == theirs.st_ino && secondsBetween(theirs, taken) == 0;
    if (!isTheirs)
        static_cast<void>(::link(own.c_str(), path.c_str()));
    fs::remove(own, ignored);
    return isTheirs ? make() : FileHandle();
}

std::unique_ptr<Claim> Claims::claim(const std::string& name) const {
    const fs::path path = pathOf(name);
    if (kind_ == ClaimKind::lock) {
        LockTry lock = tryLock(path, LockKind::exclusive, true);
        return std::unique_ptr<Claim>(lock.locked ? new Claim(path, std::move(lock.file), 0) : nullptr);
    }
    FileHandle file = takeLease(path);
    return std::unique_ptr<Claim>(file.descriptor() >= 0 ? new Claim(path, std::move(file), leaseSeconds_ / 4)
                                                         : nullptr);
}

} // namespace tessera

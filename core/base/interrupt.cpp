// core/base/interrupt.cpp: see interrupt.h. The handler only remembers and writes a byte; a thread that waits
// for the byte is the watchdog.
#include "core/base/interrupt.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <fcntl.h> // O_CLOEXEC
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <unistd.h>

namespace tessera {
namespace {

namespace fs = std::filesystem;
constexpr std::chrono::milliseconds kPatience{800};

std::atomic<int> caught{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler writes it");
thread_local const Cancellation::Flag* cancelled = nullptr;
int wake = -1; // end of a pipe that the handler writes to

/// Paths that a watchdog removes, by number.
struct Registry {
    std::mutex mutex;
    std::map<int, fs::path> paths;
    int next = 0;
};
Registry& registry() {
    static Registry* const all = new Registry; // never destroyed: the watchdog may outlive main()
    return *all;
}

void onSignal(int signal) {
    int none = 0;
    if (!caught.compare_exchange_strong(none, signal))
        ::_exit(128 + signal); // second signal
    const char byte = 0;
    [[maybe_unused]] const ssize_t written = ::write(wake, &byte, 1);
}

/// Removes a path that its owner may still be writing to. It is renamed first, so that no further files get
/// into it.
void removeUnderWriter(const fs::path& path) {
    std::error_code ignored;
    fs::path aside = path;
    aside += "-removed";
    fs::rename(path, aside, ignored);
    fs::remove_all(aside, ignored);
    fs::remove_all(path, ignored);
}

void watch(int pipeEnd) {
    char byte = 0;
    while (::read(pipeEnd, &byte, 1) < 0)
        ;
    std::this_thread::sleep_for(kPatience);
    Registry& all = registry();
    const std::lock_guard lock(all.mutex); // never released: no further path is registered
    for (const auto& [number, path] : all.paths)
        removeUnderWriter(path);
    ::_exit(128 + caught.load());
}

} // namespace

void catchInterrupts() {
    int ends[2];
    if (wake >= 0 || ::pipe2(ends, O_CLOEXEC) != 0)
        return; // without a pipe signals end the program as they always do
    wake = ends[1];
    registry();
    std::thread(watch, ends[0]).detach();
    struct sigaction action {};
    action.sa_handler = onSignal;
    action.sa_flags = SA_RESTART;
    for (const int signal : {SIGINT, SIGTERM})
        ::sigaction(signal, &action, nullptr);
    struct sigaction before {};
    // A program that nohup started goes on when its terminal goes.
    if (::sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
        ::sigaction(SIGHUP, &action, nullptr);
    std::signal(SIGXFSZ, SIG_IGN); // a file over a size limit is reported as a failed write
}

void checkInterrupted() {
    if (const int signal = caught.load(std::memory_order_relaxed))
        throw Interrupted(signal);
    if (cancelled && cancelled->load(std::memory_order_relaxed))
        throw Cancelled();
}

Cancellation::Cancellation(const Flag* flag) : before_(cancelled) {
    cancelled = flag;
}

Cancellation::~Cancellation() {
    cancelled = before_;
}

const Cancellation::Flag* Cancellation::current() {
    return cancelled;
}

TemporaryPath::TemporaryPath(const fs::path& path) {
    Registry& all = registry();
    const std::lock_guard lock(all.mutex);
    number_ = all.next++;
    all.paths.emplace(number_, fs::absolute(path));
}

void TemporaryPath::forget() {
    if (number_ < 0)
        return;
    Registry& all = registry();
    const std::lock_guard lock(all.mutex);
    all.paths.erase(number_);
    number_ = -1;
}

} // namespace tessera

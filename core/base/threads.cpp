// core/base/threads.cpp: see threads.h.
#include "core/base/threads.h"

#include "core/base/interrupt.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <pthread.h>
#include <thread>
#include <vector>

namespace tessera {
namespace {

/// A thread that waits for work between two loops. A picture in small parts runs some ten thousand loops, and
/// new threads for each would cost more than the work.
class Worker {
  public:
    Worker() {
        std::thread([this] { run(); }).detach();
    }
    void start(const std::function<void()>& work) {
        const std::lock_guard lock(mutex_);
        work_ = &work;
        changed_.notify_all();
    }
    void wait() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !work_; });
    }

  private:
    [[noreturn]] void run() {
        std::unique_lock lock(mutex_);
        for (;;) {
            changed_.wait(lock, [&] { return work_; });
            lock.unlock();
            (*work_)();
            lock.lock();
            work_ = nullptr;
            changed_.notify_all();
        }
    }
    std::mutex mutex_;
    std::condition_variable changed_;
    const std::function<void()>* work_ = nullptr; // null: it waits
};

/// The waiting threads. They are never destroyed, and wait until the process ends. A child of fork() has none
/// of them.
class Workers {
  public:
    static Workers& all() {
        static Workers* const workers = new Workers;
        return *workers;
    }
    Worker* take() {
        {
            const std::lock_guard lock(mutex_);
            if (!idle_.empty()) {
                Worker* const worker = idle_.back();
                idle_.pop_back();
                return worker;
            }
        }
        return new Worker;
    }
    void giveBack(Worker* worker) {
        const std::lock_guard lock(mutex_);
        idle_.push_back(worker);
    }

  private:
    Workers() {
        ::pthread_atfork([] { all().mutex_.lock(); }, [] { all().mutex_.unlock(); },
                         [] {
                             all().idle_.clear();
                             all().mutex_.unlock();
                         });
    }
    std::mutex mutex_;
    std::vector<Worker*> idle_;
};

/// Runs work on `others` threads and this one, until all of them are done with it.
void runBeside(std::size_t others, const std::function<void()>& work) {
    std::vector<Worker*> taken;
    taken.reserve(others);
    try {
        while (taken.size() < others) {
            taken.push_back(Workers::all().take());
            taken.back()->start(work);
        }
    } catch (const std::exception&) { // no more threads are available: the existing ones do the work
    }
    work();
    for (Worker* const worker : taken) {
        worker->wait();
        Workers::all().giveBack(worker);
    }
}

} // namespace

int defaultThreads() {
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body,
                 const ShareDone& progress) {
    const std::size_t wanted = static_cast<std::size_t>(threads > 0 ? threads : defaultThreads());
    const std::size_t used = std::min(wanted, count);
    std::atomic<std::size_t> next{0}, done{0};
    std::mutex mutex;
    std::exception_ptr failure;
    const Cancellation::Flag* const cancellation = Cancellation::current();
    const auto work = [&] {
        const Cancellation asked(cancellation);
        try {
            for (std::size_t i = next++; i < count; i = next++) {
                checkInterrupted();
                body(i);
                if (progress)
                    progress(static_cast<double>(++done) / static_cast<double>(count));
            }
        } catch (...) {
            const std::lock_guard lock(mutex);
            if (!failure)
                failure = std::current_exception();
            next = count; // the others stop at their next turn
        }
    };
    runBeside(used > 0 ? used - 1 : 0, work);
    if (failure)
        std::rethrow_exception(failure);
}

} // namespace tessera

// core/threads.cpp: see threads.h.
#include "core/threads.h"

#include "core/interrupt.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace tessera {

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
    if (used <= 1) {
        work();
    } else {
        std::vector<std::jthread> pool;
        for (std::size_t i = 0; i < used; ++i)
            pool.emplace_back(work);
    }
    if (failure)
        std::rethrow_exception(failure);
}

} // namespace tessera

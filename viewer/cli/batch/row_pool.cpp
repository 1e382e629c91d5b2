// viewer/cli/batch/row_pool.cpp: see row_pool.h.
#include "viewer/cli/batch/row_pool.h"

#include "core/base/error.h"
#include "core/base/interrupt.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace tessera {
namespace {

/// The threads of a pool, and what they are at.
class Pool {
  public:
    Pool(const std::vector<std::size_t>& rows, const DoRow& doRow, int threads)
        : rows_(rows), doRow_(doRow), atWork_(static_cast<std::size_t>(threads)),
          running_(static_cast<std::size_t>(threads)) {
        try {
            for (std::size_t n = 0; n < atWork_.size(); ++n)
                threads_.emplace_back([this, n] { work(n); });
        } catch (const std::system_error&) {
            stop();
            end();
            throw badFile("--jobs", "as many rows at once as the system has threads for",
                          std::to_string(threads) + ", of which " + std::to_string(threads_.size()) +
                              " could be started");
        }
    }
    ~Pool() { end(); }
    Pool(const Pool&) = delete;
    Pool& operator=(const Pool&) = delete;

    /// Waits for a moment, or until all is done, which it tells.
    bool wait() {
        constexpr std::chrono::milliseconds kMoment{100};
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, kMoment, [this] { return running_ == 0; });
    }
    /// "p-17 drawing 45 %"
    std::string atWork() {
        const std::lock_guard lock(mutex_);
        const auto one =
            std::ranges::find_if(atWork_, [](const RowAtWork& row) { return bool(row.progress); });
        if (one == atWork_.end())
            return {};
        const Progress::Stage stage = one->progress->now();
        std::string text = one->id + (stage.what.empty() ? "" : " " + stage.what);
        if (stage.share > 0)
            text += " " + std::to_string(static_cast<int>(100 * stage.share)) + " %";
        return text;
    }
    /// Ends the threads; throws what one threw.
    void finish() {
        end();
        if (problem_)
            std::rethrow_exception(problem_);
    }
    void stop() { stop_ = true; }

  private:
    void end() {
        for (std::thread& thread : threads_)
            if (thread.joinable())
                thread.join();
    }
    void tell(std::size_t thread, RowAtWork row) {
        const std::lock_guard lock(mutex_);
        atWork_[thread] = std::move(row);
    }
    void work(std::size_t thread) {
        try {
            for (std::size_t n = next_++; n < rows_.size() && !stop_; n = next_++) {
                checkInterrupted();
                doRow_(rows_[n], [&](RowAtWork row) { tell(thread, std::move(row)); });
                tell(thread, {});
            }
        } catch (...) {
            stop_ = true;
            const std::lock_guard lock(mutex_);
            atWork_[thread] = {};
            if (!problem_)
                problem_ = std::current_exception();
        }
        {
            const std::lock_guard lock(mutex_);
            --running_;
        }
        changed_.notify_all();
    }

    const std::vector<std::size_t>& rows_;
    const DoRow& doRow_;
    std::atomic<std::size_t> next_{0};
    std::atomic<bool> stop_{false};
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<RowAtWork> atWork_;
    std::size_t running_;
    std::exception_ptr problem_;
    std::vector<std::thread> threads_; // last
};

} // namespace

void BatchTally::add(const RowResult& result) {
    switch (result.state) {
    case RowState::drawn:
        ++drawn;
        return;
    case RowState::unchanged:
        ++unchanged;
        return;
    case RowState::byOthers:
        ++byOthers;
        return;
    case RowState::wouldBeDrawn:
        ++wouldBeDrawn;
        return;
    case RowState::failed:
        break;
    }
    ++failed;
    if (failures.size() < kMostNamed)
        failures.push_back(result);
}

void doRows(const std::vector<std::size_t>& rows, int threads, std::size_t total,
            const std::function<std::size_t()>& done, const DoRow& doRow, Progress& progress) {
    Pool pool(rows, doRow, threads);
    while (!pool.wait()) {
        const std::string now = pool.atWork();
        progress.detail(now.empty() ? "" : ", " + now);
        progress.update(static_cast<double>(done()) / static_cast<double>(std::max<std::size_t>(1, total)));
        try {
            checkInterrupted();
        } catch (...) {
            pool.stop();
            pool.finish();
            throw;
        }
    }
    pool.finish();
}

} // namespace tessera

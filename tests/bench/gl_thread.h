// tests/bench/gl_thread.h: a thread that keeps a GL context of its own beside another library's.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

namespace tessera::bench {

/// A thread that owns Tessera's GL context: EGL and VTK's GLX cannot both be current on one.
class GlThread {
  public:
    GlThread()
        : thread_([this](const std::stop_token& stop) {
              std::unique_lock lock(mutex_);
              while (wake_.wait(lock, stop, [this] { return job_ != nullptr; })) {
                  try {
                      (*job_)();
                  } catch (...) {
                      failure_ = std::current_exception();
                  }
                  job_ = nullptr;
                  done_.notify_one();
              }
          }) {}
    /// Runs the job there and waits; rethrows what it threw.
    void run(const std::function<void()>& job) {
        std::unique_lock lock(mutex_);
        job_ = &job;
        wake_.notify_one();
        done_.wait(lock, [this] { return job_ == nullptr; });
        if (failure_)
            std::rethrow_exception(std::exchange(failure_, nullptr));
    }

  private:
    std::mutex mutex_;
    std::condition_variable_any wake_;
    std::condition_variable done_;
    const std::function<void()>* job_ = nullptr;
    std::exception_ptr failure_;
    std::jthread thread_; // last: it uses all of the above
};

} // namespace tessera::bench

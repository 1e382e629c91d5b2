// viewer/session/slice_thread.h: draws the three planes on a thread of its own, the last wish first. It draws
// coarsely where that is sooner, then as finely as a screen shows.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "viewer/session/slice_frame.h"

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace tessera {

class SliceThread {
  public:
    /// @param ram  all that it has left, less a part for pictures, is the chunks' cache; as store, it
    /// outlives this
    /// @param news  is called from the thread when shown() is another, or something went wrong
    SliceThread(const StoreReader& store, MemoryBudget& ram, int threads, std::function<void()> news);
    ~SliceThread();
    void show(const SliceWish& wish);
    /// Null before there is one.
    std::shared_ptr<const ShownSlices> shown() const;
    /// What went wrong since the last call; empty: nothing.
    std::string takeProblem();
    /// RAM that the smallest cache takes.
    static std::size_t floorBytes(const VolumeInfo& info, int threads);

  private:
    void run();
    void draw(const SliceWish& wish, int coarser);
    bool hasNewWish() const;

    const StoreReader& store_;
    const int threads_;
    const std::function<void()> news_;
    BrickCache cache_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    bool stop_ = false;
    std::optional<SliceWish> wish_;
    std::optional<SliceWish> asked_; // the last wish, waiting, being drawn or shown; none where it failed
    std::shared_ptr<const ShownSlices> shown_;
    std::string problem_;
    std::thread thread_; // last: it uses all of the above
};

} // namespace tessera

// viewer/session/line_finder.h: finds a centre-line, or the coverage of a flight along it, on a thread of its
// own; can be cancelled.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "viewer/session/viewing.h"

#include <functional>
#include <future>
#include <memory>

namespace tessera {

class LineFinder {
  public:
    /// Begins.
    /// @param ended  is called from the thread just before it ends
    /// store and ram outlive this.
    LineFinder(const LineWish& wish, const StoreReader& store, MemoryBudget& ram, int threads,
               std::function<void()> ended);
    /// Cancels, and waits.
    ~LineFinder();
    void callOff() { calledOff_ = true; }
    const std::shared_ptr<Progress>& progress() const { return progress_; }
    /// The result; waits. Call once. Neither a result nor a problem: it was cancelled.
    LineState take() { return result_.get(); }

  private:
    Cancellation::Flag calledOff_{false};
    std::shared_ptr<Progress> progress_;
    std::future<LineState> result_;
};

} // namespace tessera

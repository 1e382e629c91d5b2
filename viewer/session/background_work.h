// viewer/session/background_work.h: work on threads of its own, which can be cancelled: stills, centre-lines
// and coverages.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/scene/scene.h"
#include "render/picture/render_scene.h"
#include "viewer/session/viewing.h"

#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

// A still: the picture of `tessera render`, drawn on a thread of its own; can be cancelled. Where light
// follows paths, pictures with a part of the samples come before.

struct FinishedStill {
    std::shared_ptr<ShownPicture> picture; // null: cancelled
    std::string measured, problem;         // sentences; may be empty
};

class Still {
  public:
    using Round = std::function<void(std::shared_ptr<ShownPicture>)>;
    /// Begins.
    /// @param ended  is called from the thread just before it ends
    /// @param round  is called from the thread with each picture before; none: they are not made
    /// store and budgets outlive this.
    Still(const Scene& scene, std::uint64_t asked, std::vector<const StoreReader*> stores, MemoryBudget& ram,
          MemoryBudget& gpu, const RenderOptions& options, std::function<void()> ended, Round round = {});
    /// Cancels, and waits.
    ~Still();
    void callOff() { calledOff_ = true; }
    bool isCalledOff() const { return calledOff_; }
    /// Waits. Call once.
    FinishedStill take() { return result_.get(); }

  private:
    Cancellation::Flag calledOff_{false};
    std::future<FinishedStill> result_;
};

// Finds a centre-line, or the coverage of a flight along it, on a thread of its own; can be cancelled.

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

// viewer/session/still.h: a still: the picture of `tessera render`, drawn on a thread of its own; can be
// cancelled.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/interrupt.h"
#include "core/scene/scene.h"
#include "render/picture/render_scene.h"
#include "viewer/session/viewing.h"

#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <string>

namespace tessera {

struct FinishedStill {
    std::shared_ptr<ShownPicture> picture; // null: cancelled
    std::string measured, problem;         // sentences; may be empty
};

class Still {
  public:
    /// Begins.
    /// @param ended  is called from the thread just before it ends
    /// store and budgets outlive this.
    Still(const Scene& scene, std::uint64_t asked, const StoreReader& store, MemoryBudget& ram,
          MemoryBudget& gpu, const RenderOptions& options, std::function<void()> ended);
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

} // namespace tessera

// render/plan/frame_context.h: the budgets, the threads and the progress of drawing.
#pragma once

#include "core/base/budget.h"
#include "core/base/progress.h"

namespace tessera {

class ProcessGroup;

/// All of it outlives the picture.
struct FrameContext {
    MemoryBudget& ram;
    MemoryBudget& gpu;
    int threads;        ///< of CPU engines, loaders and planning; 0: all processors
    Progress& progress; ///< may be silent
    ProcessGroup* group =
        nullptr; ///< processes that draw the picture together; null: this one draws it alone

    FrameContext(MemoryBudget& ramOf, MemoryBudget& gpuOf, int threadsOf, Progress* said = nullptr)
        : ram(ramOf), gpu(gpuOf), threads(threadsOf), progress(said ? *said : silent()) {}

  private:
    static Progress& silent() {
        thread_local Progress nobody;
        return nobody;
    }
};

} // namespace tessera

// viewer/session/finer_import.h: the import of a file's level on a thread of its own, while a coarser one is
// shown; can be cancelled.
#pragma once

#include "core/base/budget.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/options/options.h"

#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <string>

namespace tessera {

class FinerImport {
  public:
    /// Begins.
    /// @param ended  is called from the thread just before it ends
    /// ram outlives this.
    FinerImport(const std::filesystem::path& path, const InputOptions& input, MemoryBudget& ram,
                std::function<void()> ended);
    /// Cancels, and waits.
    ~FinerImport();
    /// Why there is none; "": the import is in the cache as long as this lives. Waits. Call once.
    std::string take() { return result_.get(); }

  private:
    Cancellation::Flag calledOff_{false};
    CommonOptions common_; // its own: it keeps what the import needs
    std::future<std::string> result_;
};

} // namespace tessera

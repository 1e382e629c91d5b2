// core/base/budget_error.h: OverBudget, the error where a memory budget is too small.
#pragma once

#include "core/base/error.h"

namespace tessera {

/// A budget cannot hold what is asked for: of MemoryBudget::charge(), and of plans that do not fit. The
/// message names the option that raises it; with more of it the same may succeed. Exit code 2.
class OverBudget : public InputError {
  public:
    using InputError::InputError;
};

} // namespace tessera

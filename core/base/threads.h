// core/base/threads.h: parallelFor over an index range. An atomic counter hands out the work, so results must
// not depend on which thread does what. The first exception is rethrown to the caller.
#pragma once

#include "core/base/progress.h" // ShareDone

#include <cstddef>
#include <functional>

namespace tessera {

/// Threads for a count of 0: the machine's processors.
int defaultThreads();

/// Calls body(index) for every index in [0,count), on up to `threads` threads (0: all processors). Throws
/// Interrupted between two calls after Ctrl-C, Cancelled if the caller's work is cancelled.
/// @param progress  gets the share that is done
void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body,
                 const ShareDone& progress = {});

} // namespace tessera

// render/contract/slicing.h: the division of rays into dispatches, which a device takes one at a time.
#pragma once

#include "core/base/progress.h" // ShareDone

namespace tessera {

/// The cutting of rays into dispatches. It never changes the picture; tests vary it to prove that.
struct Slicing {
    /// Adaptive: the target time of a dispatch. Its true time is not bounded: it gets the iterations that fit
    /// at the cost of those before, and takes longer where its own cost more.
    double targetMs = 80;
    int fixedTile = 0;       // pixels; 0: adaptive
    int fixedIterations = 0; // per ray and dispatch; 0: adaptive
    ShareDone progress = {}; // of the picture, after every dispatch
};

} // namespace tessera

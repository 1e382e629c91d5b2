// core/base/work.h: the machine-independent cost of a picture, for tests and reports that must not depend on
// time.
#pragma once

#include <cstdint>

namespace tessera {

/// Of paths of light.
struct PathWork {
    std::uint64_t paths = 0, bounces = 0;
    std::uint64_t lookUps = 0, nullCollisions = 0; // extinctions that were read; those that changed nothing
    std::uint64_t cells = 0;                       // boxes of bounds that ways went through
    std::uint64_t exceeded = 0;                    // extinctions above their bound
    std::uint64_t alone = 0;                       // paths that went without lanes beside them

    PathWork& operator+=(const PathWork& o) {
        paths += o.paths;
        bounces += o.bounces;
        lookUps += o.lookUps;
        nullCollisions += o.nullCollisions;
        cells += o.cells;
        exceeded += o.exceeded;
        alone += o.alone;
        return *this;
    }
};

struct Work {
    std::uint64_t iterations = 0; // loop iterations of rays: segments taken and leaps over empty space
    std::uint64_t segments = 0;   // strides sampled
    std::uint64_t samples = 0;    // evaluations of the field, including those of gradients
    std::uint64_t fetches = 0;    // texel fetches and filtered fetches of voxels
    std::uint64_t blended = 0;    // evaluations that took samples of more than one brick (mixed levels)
    std::uint64_t dispatches = 0;
    std::uint64_t bricksUploaded = 0, bytesUploaded = 0;
    PathWork paths;
    double longestDispatchMs = 0;
    double marchMs = 0; // all dispatches, compilation not included

    Work& operator+=(const Work& o) {
        iterations += o.iterations;
        segments += o.segments;
        samples += o.samples;
        fetches += o.fetches;
        blended += o.blended;
        paths += o.paths;
        return *this;
    }
};

} // namespace tessera

// tests/bench/accuracy/area_sweep.h: the cost and gain of samples of a pixel, against the mean over its area.
// Compared are one ray with shorter steps, equally many rays for every pixel, and rays where pixels need
// them.
#pragma once

#include "tests/bench/accuracy/sweep.h"
#include "tests/bench/report/report.h"

#include <string>
#include <vector>

namespace tessera::accuracy {

struct AreaPoint {
    std::string method;      // "one ray", "uniform", "auto"
    std::string setting;     // "step 1/4", "8 samples"
    double ms = 0;           // to draw; the least of several
    double samples = 1;      // a pixel, in the mean
    double rms = 0, p99 = 0; // linear; L*u*v*
};

struct AreaSweep {
    std::string scene, about;
    glm::ivec2 imageSize{0};
    double stepVoxels = 0; // of uniform samples and auto
    int truthSamples = 0;  // of each pixel
    int repeats = 0;       // of each time
    std::vector<AreaPoint> points;
};

/// On the native engine, at most 160 pixels an axis (64 where options.effort.quick); the truth is the mean of
/// 256 samples (64 where quick) with half of the shortest step. Throws InputError where the budgets are too
/// short.
AreaSweep runAreaSweep(const NamedScene& scene, const SweepOptions& options);

/// A table and a figure of work and precision for each scene.
bench::Report areaSection(const std::vector<AreaSweep>& sweeps);

} // namespace tessera::accuracy

// tests/bench/accuracy/light_sweep.h: the error and the cost of voxel light. Its rays, their reach, the
// points that shadow maps keep of a ray, and the level that light is kept at are each changed alone.
#pragma once

#include "tests/bench/accuracy/sweep.h"
#include "tests/bench/report/report.h"

#include <optional>
#include <string>
#include <vector>

namespace tessera::accuracy {

struct LightPoint {
    std::string axis;                  // "as it is", "rays", "radius", "layers", "finest level"
    std::string setting;               // "32 rays", "8 mm"
    double seconds = 0;                // computing the light, the least of several
    double bytes = 0;                  // of light beside the bricks, and of maps
    double rms = 0, bias = 0, p99 = 0; // linear; linear; L*u*v*
};

struct LightSweep {
    std::string scene;
    glm::ivec2 imageSize{0};
    int truthRays = 0;       // of occlusion; 0: there is none
    int repeats = 0;         // of each time
    double withoutLight = 0; // rms of the same picture without light of voxels against a truth without it
    std::vector<LightPoint> points;
};

/// On the native engine, 32 pixels an axis at most (12 where options.effort.quick), against the reference,
/// whose rays of occlusion are 320 at least. Nothing for scenes without light of voxels. Throws InputError
/// where the budgets are too short.
std::optional<LightSweep> runLightSweep(const NamedScene& scene, const SweepOptions& options);

/// A table, and a figure of error and time for each scene.
bench::Report lightSection(const std::vector<LightSweep>& sweeps);

} // namespace tessera::accuracy

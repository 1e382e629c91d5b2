// render/light/occlusion_rays.h: the rays of local ambient occlusion from a sample (course notes 6.1), on the
// lattice of a level. A ray goes from layer to layer along its steepest axis, a step each. So the samples of
// all voxels' rays lie at the same offsets between lattice points (docs/sampling.md, "Light per voxel").
#pragma once

#include "core/base/volume.h"
#include "core/scene/lighting.h"

#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

struct OcclusionRay {
    glm::dvec3 direction; // unit, patient space
    double part = 0;      // of the sphere that it stands for
    int axis = 0;         // that its steps are a sample along
    glm::dvec3 step;      // samples of the level
    double stepMm = 0;    // a step's length
    int skipped = 0;      // steps before the first that counts
    int steps = 1;        // that count; the field is read at both ends of each
};

struct OcclusionRays {
    std::vector<OcclusionRay> rays; // by length of step, ascending
    glm::ivec3 reach{0};            // samples around one that rays read, to either side
};

/// Most steps of a ray.
constexpr int kMostOcclusionSteps = 32;

/// The finest level on which no ray takes more steps than kMostOcclusionSteps.
int occlusionLevel(const Occlusion& occlusion, const VolumeInfo& info);
/// @param level  occlusionLevel() or coarser
OcclusionRays occlusionRays(const Occlusion& occlusion, const VolumeInfo& info, int level);

} // namespace tessera

// render/light/directions.h: directions spread over the sphere: the centres of the faces of a tetrahedron, an
// octahedron or an icosahedron. Faces are subdivided into four repeatedly (course notes 6.1). Such faces
// differ in size, so each direction has the solid angle of its face as weight. The rays of local ambient
// occlusion from a sample (course notes 6.1), on the lattice of a level. A ray steps from layer to layer
// along its steepest axis. So the ray's samples have the same offsets between lattice points for all voxels
// (docs/sampling.md, "Light per voxel").
#pragma once

#include "core/base/volume.h"
#include "core/scene/lighting.h"

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// True if a solid has this number of faces: 4, 8 or 20 times a power of four.
bool isDirectionCount(int count);
struct SphereDirection {
    glm::dvec3 towards; // unit
    double part = 0;    // its share of the sphere: w_k of equation 6.1 over their number
};
/// Parts sum to 1, directions weighted by them to zero. The same for the same count (checked:
/// isDirectionCount()).
std::vector<SphereDirection> sphereDirections(int count);

/// Those of an occlusion's rays, with its weights of directions. Parts sum to 1.
std::vector<SphereDirection> occlusionDirections(const Occlusion& occlusion);

/// A surface at a place, by its extinctions: for OcclusionDirections::hemisphere.
struct SurfaceAround {
    glm::vec3 normal{0}; // unit, patient space, away from the denser side; 0: none
    float share = 0;     // of it in the weights of rays: 0 in an even medium, 1 at an edge
};
/// @param rise  of extinction along the axes of voxels: half of its difference over two pitches
/// @param mean  of the six extinctions beside
/// @param toPatient  of gradients
SurfaceAround surfaceAround(const glm::vec3& rise, float mean, const glm::mat3& toPatient);

struct OcclusionRay {
    glm::dvec3 direction; // unit, patient space
    double part = 0;      // its weight among all rays
    int axis = 0;         // its steepest axis
    glm::dvec3 step;      // samples of the level
    double stepMm = 0;    // a step's length
    int skipped = 0;      // steps before the first that counts
    int steps = 1;        // steps that count; the field is read at both ends of each
};

struct OcclusionRays {
    std::vector<OcclusionRay> rays; // by length of step, ascending
    glm::ivec3 reach{0};            // reach of rays in samples, to either side
};

/// Largest number of steps of a ray.
constexpr int kMostOcclusionSteps = 32;

/// The finest level on which no ray takes more steps than kMostOcclusionSteps.
int occlusionLevel(const Occlusion& occlusion, const VolumeInfo& info);
/// @param level  occlusionLevel() or coarser
OcclusionRays occlusionRays(const Occlusion& occlusion, const VolumeInfo& info, int level);

} // namespace tessera

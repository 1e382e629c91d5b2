// bricking/analysis/lumen/seed_threshold.h: the threshold of a lumen from a seed in it: half way between the
// lumen's value and the wall's, as the edges around the seed have them.
#pragma once

#include "bricking/analysis/lumen/lumen_values.h"

#include <string>

namespace tessera {

struct SeedNeighbourhood {
    double lumen = 0; ///< median of the values around the seed, physical units
    double wall = 0;  ///< median of the walls', physical units
    double noise = 0; ///< standard deviation of the values' noise (value_noise.h)
    LumenRule rule;   ///< half way to the wall; contrast no brighter than 1.5 times that beyond the lumen
    double contrast() const; ///< from the lumen's value to the wall's, twice as far as the threshold
    /// Noise so strong that single values tell little: it is better taken off first (quiet_values.h).
    bool noisy() const;
};

/// Rays go out from the seed in 42 directions until the value has left the lumen's and stays away for 1.5 mm
/// or three voxels, whichever is less. A voxel of noise is no wall. It has left by six times the spread
/// around the seed, and a twentieth of what all rays meet at least, a quarter at most. Where it then goes no
/// further, that is the wall's. The median over the rays decides, of the values and of the side.
/// @param seed  voxel space, in the volume
/// @param name  of the seed, in messages. Throws InputError where no edge is met within 100 mm.
SeedNeighbourhood neighbourhoodOf(LumenValues& values, const glm::dvec3& seed, const std::string& name);
/// The same for a threshold that is given: which side the seed is on; the wall is as far beyond it.
SeedNeighbourhood neighbourhoodOf(LumenValues& values, const glm::dvec3& seed, double threshold);

} // namespace tessera

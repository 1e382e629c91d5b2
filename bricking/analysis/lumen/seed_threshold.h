// bricking/analysis/lumen/seed_threshold.h: the threshold of a lumen from a seed in it: half way between the
// values of the lumen and of the wall around the seed.
#pragma once

#include "bricking/analysis/lumen/lumen_values.h"

#include <string>

namespace tessera {

// The noise of the values around a point, measured from the values themselves. Scanners and exports clip air
// at the lowest value, so only unclipped values count.

struct ValueNoise {
    double deviation = 0;    ///< standard deviation, physical units; 0: none, or unknown
    double clippedShare = 0; ///< share of voxels around with the lowest value there; 0 below a fiftieth
};

/// Differences of voxels two apart along the two axes with the finest spacing, in blocks of 4^3 voxels within
/// 20 mm, 8 to 16 voxels. The quarter of the blocks with the least noise decides: the others have edges.
/// Pairs with a clipped value do not count. In a partly clipped block the remaining noise is scaled to a full
/// normal distribution.
/// @param place  voxel space, in the volume
ValueNoise noiseAround(LumenValues& values, const glm::dvec3& place);

struct SeedNeighbourhood {
    double lumen = 0; ///< median of the values around the seed, physical units
    double wall = 0;  ///< median of the wall's values, physical units
    double noise = 0; ///< standard deviation of the values' noise
    LumenRule rule;   ///< half way to the wall; contrast also has an upper bound, 1.5 times as far beyond the
                      ///< lumen's value
    double contrast() const; ///< from the lumen's value to the wall's, twice the distance to the threshold
    /// True if noise is so strong that values should be denoised first (lumen_values.h).
    bool noisy() const;
};

/// Rays go out from the seed in 42 directions until the value has left the lumen's for 1.5 mm or three
/// voxels, whichever is less. So a voxel of noise is no wall. The required difference is six times the spread
/// around the seed, within a twentieth and a quarter of the range on all rays. The wall's value is where it
/// then stops changing. The median over the rays decides the values and the side.
/// @param seed  voxel space, in the volume
/// @param name  of the seed, in messages. Throws InputError if there is no edge within 100 mm.
SeedNeighbourhood neighbourhoodOf(LumenValues& values, const glm::dvec3& seed, const std::string& name);
/// The same for a given threshold: finds the seed's side; the wall is as far beyond the threshold.
SeedNeighbourhood neighbourhoodOf(LumenValues& values, const glm::dvec3& seed, double threshold);

} // namespace tessera
